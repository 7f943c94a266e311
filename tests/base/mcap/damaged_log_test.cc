// SPDX-License-Identifier: Apache-2.0
// Logs that were cut anywhere, or in which any byte is another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <set>
#include <string>

#include "base/diagnostics.h"
#include "base/mcap/compression.h"
#include "base/mcap/wire.h"
#include "base/stopwatch.h"
#include "tests/base/mcap/sample_log.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::mcap {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kMost_s = 0.5;  // of one small file, on a busy machine; it takes some 0.1 ms

class DamagedMcapTest : public InTemporaryFolder {
 protected:
  std::filesystem::path file() const { return folder_ / "log.mcap"; }
  // In place: a file that is written anew thousands of times waits for the disk each time.
  void Poke(std::size_t at, char byte) const {
    std::fstream to(file(), std::ios::in | std::ios::out | std::ios::binary);
    to.seekp(static_cast<std::streamoff>(at));
    to.put(byte);
  }
};

// How many messages lie in chunks that end before each offset.
std::size_t WholeBefore(std::size_t cut, const std::string& bytes) {
  std::size_t messages = 0;
  for (std::size_t at = kMagic.size(); at + kRecordHead <= cut;) {
    Cursor head(std::string_view(bytes).substr(at));
    const auto op = static_cast<Op>(head.Get<std::uint8_t>(""));
    const auto length = head.Get<std::uint64_t>("");
    if (op == Op::kDataEnd || length > cut - at - kRecordHead) break;
    if (op == Op::kChunk) {
      Cursor fields(head.Bytes(length, ""));
      fields.Bytes(16, "");
      const auto size = fields.Get<std::uint64_t>("");
      fields.Get<std::uint32_t>("");
      const std::string name(fields.Text(""));
      const std::string records =
          Decompress(name, fields.Bytes(fields.Get<std::uint64_t>(""), ""), size).bytes;
      for (Cursor each(records); each.left() > 0;) {
        messages += each.Get<std::uint8_t>("") == static_cast<std::uint8_t>(Op::kMessage);
        each.Bytes(each.Get<std::uint64_t>(""), "");
      }
    }
    at += kRecordHead + length;
  }
  return messages;
}

TEST_F(DamagedMcapTest, CutAtEachByteItGivesAllWholeMessagesBeforeAndSaysSo) {
  for (const Compression compression : {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    const std::vector<Copy> written = WriteSample(file(), compression, 24, 300);
    const std::string bytes = Content(file());
    std::size_t refused = 0, of_cut_chunks = 0;
    ASSERT_EQ(WholeBefore(bytes.size(), bytes), written.size());
    for (std::size_t cut = bytes.size(); cut-- > 0;) {
      std::filesystem::resize_file(file(), cut);
      const auto began = std::chrono::steady_clock::now();
      try {
        Reader reader(file());
        const std::vector<Copy> read = AllOf(reader);
        const std::size_t whole = WholeBefore(cut, bytes);
        ASSERT_GE(read.size(), whole) << "cut at " << cut;
        ASSERT_LE(read.size(), written.size());
        of_cut_chunks += read.size() > whole;
        ASSERT_TRUE(std::equal(read.begin(), read.end(), written.begin())) << "cut at " << cut;
        ASSERT_THAT(reader.damage(), HasSubstr("byte ")) << "cut at " << cut;
        ASSERT_EQ(reader.message_count(), read.size());
      } catch (const InputError&) {
        ++refused;
        ASSERT_LT(cut, 100u) << "beyond the header";
      }
      ASSERT_LT(SecondsSince(began), kMost_s);
    }
    EXPECT_GT(refused, kMagic.size());
    if (compression == Compression::kNone) {
      EXPECT_GT(of_cut_chunks, 0u);
    }
  }
}

TEST_F(DamagedMcapTest, WithAnyByteAnotherItGivesNoMessageThatWasNotWritten) {
  for (const Compression compression : {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    const std::vector<Copy> written = WriteSample(file(), compression, 16, 250);
    const std::multiset<Copy> all(written.begin(), written.end());
    const std::string bytes = Content(file());
    std::size_t read_files = 0, silent_losses = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      for (const unsigned char flip : {0x01, 0xff}) {
        Poke(at, static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ flip));
        const auto began = std::chrono::steady_clock::now();
        try {
          Reader reader(file());
          ++read_files;
          std::multiset<Copy> left = all;
          for (const Copy& each : AllOf(reader)) {
            const auto same = left.find(each);
            ASSERT_TRUE(same != left.end())
                << "byte " << at << ": " << each.topic << " at " << each.log_time_ns;
            left.erase(same);
          }
          silent_losses += !left.empty() && reader.damage().empty();
        } catch (const InputError&) {
          ASSERT_LT(at, 100u) << "beyond the header";
        }
        ASSERT_LT(SecondsSince(began), kMost_s);
      }
      Poke(at, bytes[at]);
    }
    EXPECT_GT(read_files, bytes.size());
    EXPECT_EQ(silent_losses, 0u);
  }
}

TEST_F(DamagedMcapTest, AChunkInTheMiddleThatIsDamagedCostsItsOwnMessagesAlone) {
  const std::vector<Copy> written = WriteSample(file(), Compression::kZstd);
  const std::string bytes = Content(file());
  const std::size_t in_chunk = bytes.find("\x28\xb5\x2f\xfd", bytes.size() / 3);  // zstd's magic
  ASSERT_NE(in_chunk, std::string::npos);
  Poke(in_chunk + 12, static_cast<char>(bytes[in_chunk + 12] ^ 0x10));
  Reader reader(file());
  const std::vector<Copy> read = AllOf(reader);
  EXPECT_LT(read.size(), written.size());
  EXPECT_GT(read.size(), written.size() / 2);
  EXPECT_EQ(read.front(), written.front());
  EXPECT_EQ(read.back(), written.back());
  EXPECT_THAT(reader.damage(), HasSubstr("byte "));
}

TEST(McapCompression, GivesNoMoreThanIsSaidToBeThere) {
  const std::string zeros(8 << 20, '\0');
  for (const Compression compression : {Compression::kLz4, Compression::kZstd}) {
    const std::string small = Compress(compression, zeros);
    ASSERT_LT(small.size(), zeros.size() / 100);
    EXPECT_EQ(Decompress(NameOf(compression), small, zeros.size()).bytes, zeros);
    EXPECT_THAT(Decompress(NameOf(compression), small, zeros.size()).error, IsEmpty());
    const Decompressed bomb = Decompress(NameOf(compression), small, 100);
    EXPECT_LE(bomb.bytes.size(), 100u);
    EXPECT_THAT(bomb.error, HasSubstr("more than"));
    EXPECT_THAT(Decompress(NameOf(compression), small, std::uint64_t{1} << 60).error,
                HasSubstr("is said to hold"));
    EXPECT_THAT(Decompress(NameOf(compression), small.substr(0, small.size() / 2), zeros.size()).error,
                Not(IsEmpty()));
  }
  EXPECT_THAT(Decompress("brotli", "x", 1).error, HasSubstr("'brotli' is not known"));
}

}  // namespace
}  // namespace kestrel::mcap
