// SPDX-License-Identifier: Apache-2.0
// What the writer wrote is what the reader gives. That others read it too, and by the specification alone, is
// held by tests/peers/mcap.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "base/diagnostics.h"
#include "base/mcap/wire.h"
#include "tests/base/mcap/sample_log.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::mcap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class McapLogFileTest : public InTemporaryFolder {
 protected:
  std::filesystem::path file() const { return folder_ / "log.mcap"; }
  void Write(const std::string& bytes) const { std::ofstream(file(), std::ios::binary) << bytes; }
  std::string Refusal() const {
    try {
      Reader reader(file());
    } catch (const InputError& e) {
      return e.what();
    }
    return "read";
  }
};

TEST_F(McapLogFileTest, GivesWhatWasWrittenInEachCompression) {
  for (const Compression compression : {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    const std::vector<Copy> written = WriteSample(file(), compression);
    Reader reader(file());
    EXPECT_TRUE(reader.indexed());
    EXPECT_EQ(reader.profile(), "ros2");
    EXPECT_EQ(reader.message_count(), written.size());
    EXPECT_EQ(reader.from_ns(), written.front().log_time_ns);
    EXPECT_EQ(reader.until_ns(), written.back().log_time_ns);
    EXPECT_EQ(AllOf(reader), written);
    EXPECT_EQ(reader.channels().at(0), kFast);
    EXPECT_EQ(reader.channels().at(1), kSlow);
    EXPECT_THAT(reader.attachment_names(), ElementsAre("notes.txt"));
    const auto attachment = reader.ReadAttachment("notes.txt");
    ASSERT_TRUE(attachment);
    EXPECT_EQ(attachment->data, "what was attached");
    EXPECT_EQ(attachment->media_type, "text/plain");
    EXPECT_EQ(reader.ReadMetadata("flight").at("seed"), "7");
    EXPECT_THAT(reader.damage(), IsEmpty());
  }
}

TEST_F(McapLogFileTest, GivesTopicsAndTimesThatAreAskedFor) {
  const std::vector<Copy> written = WriteSample(file(), Compression::kLz4);
  Reader reader(file());
  const std::uint64_t from = written[10].log_time_ns, until = written[30].log_time_ns;
  reader.Select({"/slow"}, from, until);
  std::vector<Copy> wanted;
  std::copy_if(written.begin(), written.end(), std::back_inserter(wanted), [&](const Copy& each) {
    return each.topic == "/slow" && each.log_time_ns >= from && each.log_time_ns <= until;
  });
  ASSERT_GT(wanted.size(), 2u);
  EXPECT_EQ(AllOf(reader), wanted);
  reader.Select({"/no such topic"});
  EXPECT_THAT(AllOf(reader), IsEmpty());
  reader.Select({});
  EXPECT_EQ(AllOf(reader), written);
}

TEST_F(McapLogFileTest, WhatWasWrittenOutOfOrderComesInTheOrderOfItsTimes) {
  {
    Writer writer(file(), {"", Compression::kNone, 100});
    const std::uint16_t fast = writer.Add(kFast);
    for (const std::uint64_t t_ns : {50u, 10u, 90u, 30u, 70u, 20u, 80u, 40u, 60u})
      writer.Write(fast, t_ns, std::string(60, 'x'));
    writer.Close();
  }
  Reader reader(file());
  std::vector<std::uint64_t> times;
  for (const Copy& each : AllOf(reader)) times.push_back(each.log_time_ns);
  EXPECT_THAT(times, ElementsAre(10, 20, 30, 40, 50, 60, 70, 80, 90));
}

// By the diagrams of the specification: without chunks, without a summary.
TEST_F(McapLogFileTest, ReadsMessagesOutsideOfChunks) {
  std::string bytes(kMagic), header, schema, channel, message, end;
  PutText(header, ""), PutText(header, "by hand");
  Put(schema, std::uint16_t{7}), PutText(schema, "S"), PutText(schema, "ros2msg"), PutText(schema, "bool b");
  Put(channel, std::uint16_t{3}), Put(channel, std::uint16_t{7}), PutText(channel, "/t"),
      PutText(channel, "cdr"), PutMap(channel, {});
  Put(message, std::uint16_t{3}), Put(message, std::uint32_t{5}), Put(message, std::uint64_t{11}),
      Put(message, std::uint64_t{10});
  message += "data";
  PutRecord(bytes, Op::kHeader, header);
  PutRecord(bytes, Op::kSchema, schema);
  PutRecord(bytes, Op::kChannel, channel + "a field of later versions");
  PutRecord(bytes, Op::kMessage, message);
  PutRecord(bytes, Op{0x90}, "an application's own");
  PutRecord(bytes, Op::kDataEnd, std::string(4, '\0'));
  PutRecord(bytes, Op::kFooter, std::string(20, '\0'));
  Write(bytes + std::string(kMagic));
  Reader reader(file());
  EXPECT_FALSE(reader.indexed());
  EXPECT_EQ(reader.message_count(), 1u);
  EXPECT_THAT(AllOf(reader), ElementsAre(Copy{"/t", 5, 11, "data"}));
  EXPECT_EQ(reader.channels().at(3).schema.name, "S");
  EXPECT_THAT(reader.damage(), IsEmpty());
}

TEST_F(McapLogFileTest, WhatIsNoMcapIsRefusedWithWhatItIs) {
  EXPECT_THAT(Refusal(), HasSubstr("there is no file"));
  Write("");
  EXPECT_THAT(Refusal(), HasSubstr("no MCAP file"));
  Write("a text, as long as you like, but none of these");
  EXPECT_THAT(Refusal(), HasSubstr("no MCAP file"));
  Write("\x89MCAP1\r\n and more of it");
  EXPECT_THAT(Refusal(), HasSubstr("version '1'"));
  Write(std::string(kMagic) + "\x05 no header to begin with");
  EXPECT_THAT(Refusal(), HasSubstr("first record is no header"));
  Write(std::string(kMagic) + std::string("\x01\xff\xff\xff\xff\xff\xff\xff\x7f", 9));
  EXPECT_THAT(Refusal(), HasSubstr("no whole header"));
}

TEST(McapWire, CheckSumIsThatOfZlib) {
  EXPECT_EQ(Crc32("123456789"), 0xCBF43926u);  // the check value of CRC-32/ISO-HDLC
  EXPECT_EQ(Crc32(""), 0u);
}

}  // namespace
}  // namespace kestrel::mcap
