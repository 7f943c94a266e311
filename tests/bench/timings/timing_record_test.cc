// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timing_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/file/files.h"

namespace kestrel::bench {
namespace {

using testing::HasSubstr;

TimingRecord Record() {
  const CalibratedBlock block{.work = {10.25, 11.5, 4}, .arithmetic = {5, 5.5, 1}, .memory = {7, 7.25, 1}};
  const TimingRound round = {{"a", {block, block}}, {"b", {block}}};
  return {"1.0 abc", {{"processor", "of a test"}, {"cores", "2"}}, {round, round}};
}

class TimingRecordTest : public testing::Test {
 protected:
  std::filesystem::path File(const std::string& text) {
    const auto file = std::filesystem::path(testing::TempDir()) /
                      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".json");
    WriteFile(file, text);
    return file;
  }
  std::string Mistake(const std::string& text) {
    Mistakes mistakes;
    ReadTimingRecord(File(text), mistakes);
    return mistakes.empty() ? "none" : mistakes.Texts().front();
  }
};

TEST_F(TimingRecordTest, ReadsWhatItWrote) {
  Mistakes mistakes;
  const TimingRecord read = ReadTimingRecord(File(ToJson(Record())), mistakes);
  EXPECT_TRUE(mistakes.empty());
  EXPECT_EQ(read.version, "1.0 abc");
  EXPECT_EQ(read.machine, Record().machine);
  ASSERT_EQ(read.rounds.size(), 2u);
  ASSERT_EQ(read.rounds[1].at("a").size(), 2u);
  const CalibratedBlock& block = read.rounds[1].at("a")[1];
  EXPECT_EQ(block.work.processor_ms, 10.25);
  EXPECT_EQ(block.work.wall_ms, 11.5);
  EXPECT_EQ(block.work.pieces, 4);
  EXPECT_EQ(block.arithmetic.wall_ms, 5.5);
  EXPECT_EQ(block.memory.processor_ms, 7);
}

TEST_F(TimingRecordTest, WhatIsNoneIsRefusedByItsFileAndWhy) {
  EXPECT_THAT(Mistake("flight"), HasSubstr("is no JSON"));
  EXPECT_THAT(Mistake("[{\"name\": \"x\", \"value\": 1}]"), HasSubstr("is no run of `bench timings`"));
  EXPECT_THAT(Mistake("{\"kind\": \"kestrel timings\", \"format\": 1, \"columns\": []}"),
              HasSubstr("other columns"));
  const auto changed = [](auto change) {
    auto json = nlohmann::ordered_json::parse(ToJson(Record()));
    change(json);
    return json.dump();
  };
  EXPECT_THAT(Mistake(changed([](auto& j) { j["rounds"].erase(1); })), HasSubstr("fewer than two rounds"));
  EXPECT_THAT(Mistake(changed([](auto& j) { j["rounds"][1].erase("b"); })), HasSubstr("a round without 'b'"));
  EXPECT_THAT(Mistake(changed([](auto& j) { j["rounds"][0]["b"][0][0] = -1; })), HasSubstr("not above 0"));
  EXPECT_THAT(Mistake(changed([](auto& j) { j["rounds"][0]["b"][0].erase(0); })), HasSubstr("not whole"));
  EXPECT_THAT(Mistake(changed([](auto& j) { j.erase("version"); })), HasSubstr("lacks a part"));
  Mistakes mistakes;
  ReadTimingRecord("no_such_file.json", mistakes);
  ASSERT_FALSE(mistakes.empty());
  EXPECT_THAT(mistakes.Texts().front(), HasSubstr("no_such_file.json"));
}

TEST(TimingMachine, AnotherProcessorOrInstructionSetIsNotComparableAnotherLibraryIs) {
  const TimingMachine here = {
      {"processor", "A"}, {"cores", "2"}, {"instruction_set", "avx2"}, {"opencv", "4.6"}};
  TimingMachine there = here;
  there["opencv"] = "4.7";
  EXPECT_TRUE(WhyNotComparable(there, here).empty());
  there["instruction_set"] = "avx512";
  there.erase("cores");
  EXPECT_THAT(
      WhyNotComparable(there, here),
      testing::ElementsAre("cores: not told there, 2 here", "instruction_set: avx512 there, avx2 here"));
}

TEST(TimingMachine, TheProcessorIsTheOneOfCpuinfo) {
  EXPECT_EQ(ProcessorIn("processor\t: 0\nmodel\t\t: 1\nmodel name\t: AMD EPYC 7763\nmodel name\t: B\n"),
            "AMD EPYC 7763");
  EXPECT_EQ(ProcessorIn("processor\t: 0\nCPU implementer\t: 0x41\nCPU part\t: 0xd0c\n"), "0xd0c");
  EXPECT_EQ(ProcessorIn(""), "unknown");
}

}  // namespace
}  // namespace kestrel::bench
