// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "base/file/files.h"
#include "bench/timings/measure_timings.h"
#include "bench/timings/timing_machine.h"
#include "bench/timings/timing_record.h"
#include "bench/timings/timing_server.h"

namespace kestrel::bench {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

// A program that says its times instead of taking them: those of "frame" as told, of all else the same, with an error
// of up to 1 % that is another in each process, and over eight of them is none on the whole.
fs::path Says(const std::string& name, double frame_ms, const std::string& set = "avx2",
              const std::string& more_work = "") {
  const fs::path folder = fs::path(testing::TempDir()) / "timed_program";
  fs::create_directories(folder);
  const fs::path file = folder / name;
  fs::remove(file.string() + ".starts");
  WriteFile(file, fmt::format(R"(#!/bin/sh
[ "$1 $2 $3" = "bench timings --in-turn" ] || exit 9
echo '{{"kestrel_timings": 1, "version": "{}", "machine": {{"instruction_set": "{}"}}, "work": ["frame", "start"{}]}}'
n=$(cat "$0.starts" 2>/dev/null || echo 0)
echo $((n + 1)) >"$0.starts"
error=$(((n * {}) % 10))
while read -r work; do
  us=30000
  [ "$work" = frame ] && us={}
  echo "$((us * 2 * (1000 + error) / 1000))e-3 100 2"
done
)",
                              name, set, more_work, name == "now" ? "3 + 4" : "7",
                              static_cast<int>(1000 * frame_ms)));
  fs::permissions(file, fs::perms::owner_all);
  return file;
}

const TimingProgress kNothing = [](int, const std::string&) {};

TEST(TimedProgram, FivePercentOfOneWorkAreSeenAndTheOtherIsTheSame) {
  const InterleavedTimings timings =
      MeasureInterleaved(Says("before", 20), Says("now", 21), 8, TimingClock::kProcessor, kNothing);
  EXPECT_EQ(timings.version_before, "before");
  EXPECT_EQ(timings.version_now, "now");
  const std::vector<SpeedRow> rows = Compare(timings);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].work, "frame");
  EXPECT_NEAR(rows[0].before_ms, 20, 0.3);
  EXPECT_NEAR(rows[0].now_ms, 21, 0.3);
  EXPECT_NEAR(rows[0].ratio.ratio.value, 1.05, 0.01);
  EXPECT_EQ(rows[0].ratio.verdict, SpeedVerdict::kSlower);
  EXPECT_EQ(rows[1].work, "start");
  EXPECT_EQ(rows[1].ratio.verdict, SpeedVerdict::kSame);
}

TEST(TimedProgram, TheWallsClockIsAnotherColumn) {
  const InterleavedTimings timings =
      MeasureInterleaved(Says("before", 20), Says("now", 21), 2, TimingClock::kWall, kNothing);
  EXPECT_EQ(timings.pairs.at("frame").front().front().before, 50);
}

TEST(TimedProgram, ARunIsComparedByItsCalibrations) {
  // Both calibrations and all work take a third longer on the machine of now; "frame" 5 % more than that.
  const auto record = [](double machine, double frame) {
    TimingRecord r{"v", {}, {}};
    for (int i = 0; i < 8; ++i) {
      const double process = 1 + 0.002 * ((i * 3) % 5);
      const auto block = [&](double ms) {
        return CalibratedBlock{.work = {ms * machine * process, ms, 1},
                               .arithmetic = {5 * machine, 5, 1},
                               .memory = {7 * machine, 7, 1}};
      };
      r.rounds.push_back({{"frame", {block(20 * frame)}}, {"start", {block(30)}}});
    }
    return r;
  };
  const std::vector<SpeedRow> rows = Compare(record(1, 1), record(1.33, 1.05), TimingClock::kProcessor);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(rows[0].ratio.ratio.value, 1.05, 1e-9);
  EXPECT_EQ(rows[0].ratio.verdict, SpeedVerdict::kSlower);
  EXPECT_NEAR(rows[1].ratio.ratio.value, 1, 1e-9);
  EXPECT_EQ(rows[1].ratio.verdict, SpeedVerdict::kSame);
}

TEST(TimedProgram, WhatIsNoSuchProgramOrOfAnotherInstructionSetIsRefused) {
  const auto refusal = [](const fs::path& before) -> std::string {
    try {
      MeasureInterleaved(before, Says("now", 21), 2, TimingClock::kProcessor, kNothing);
    } catch (const InputError& e) {
      return e.what();
    }
    return "none";
  };
  EXPECT_THAT(refusal("/bin/true"), HasSubstr("/bin/true: the program does not answer"));
  EXPECT_THAT(refusal("/bin/echo"), HasSubstr("does not answer"));
  EXPECT_THAT(refusal(Says("other_set", 20, "avx512")),
              HasSubstr("instruction_set: avx512 there, avx2 here"));
}

TEST(TimedProgram, WhatNeverAnswersIsEndedAndRefused) {
  const fs::path folder = fs::path(testing::TempDir()) / "timed_program", file = folder / "silent";
  fs::create_directories(folder);
  WriteFile(file, "#!/bin/sh\necho $$ >\"$0.id\"\nsleep 1000\n");
  fs::permissions(file, fs::perms::owner_all);
  EXPECT_THROW(TimedProgram(file, 0.3), InputError);
  EXPECT_NE(kill(std::stoi(ReadFile(file.string() + ".id")), 0), 0);
}

TEST(TimedProgram, AnExecutableTextIsRefused) {
  const fs::path folder = fs::path(testing::TempDir()) / "timed_program", file = folder / "text";
  fs::create_directories(folder);
  WriteFile(file, "{}");
  fs::permissions(file, fs::perms::owner_all);
  EXPECT_THROW(TimedProgram{file}, InputError);
}

TEST(TimedProgram, WorkOfOneAloneIsNamedAndNotCompared) {
  const InterleavedTimings timings = MeasureInterleaved(
      Says("before", 20), Says("more", 20, "avx2", ", \"new\""), 2, TimingClock::kProcessor, kNothing);
  EXPECT_THAT(timings.of_one_alone, ElementsAre("new"));
  EXPECT_EQ(timings.pairs.size(), 2u);
}

TEST(TimedProgram, AProgramThatEndsOrGivesNoTimesSaysSo) {
  const fs::path file = Says("no_times", 0);
  TimedProgram program(file);
  EXPECT_THROW(program.Time("frame"), std::runtime_error);
}

TEST(TimingServer, AnswersEachLineOrSaysWhyNot) {
  std::istringstream in("arithmetic\nno such work\n");
  std::ostringstream out;
  ServeTimings(in, out);
  std::istringstream lines(out.str());
  std::string greeting, times, refusal;
  std::getline(lines, greeting), std::getline(lines, times), std::getline(lines, refusal);
  EXPECT_THAT(greeting, HasSubstr("\"kestrel_timings\":1"));
  double processor_ms = 0, wall_ms = 0, pieces = 0;
  std::istringstream(times) >> processor_ms >> wall_ms >> pieces;
  EXPECT_GT(processor_ms, 0.1);
  EXPECT_GT(wall_ms, 0.1);
  EXPECT_EQ(pieces, 1);
  EXPECT_THAT(refusal, HasSubstr("! "));
  EXPECT_THAT(refusal, HasSubstr("no such work"));
}

TEST(BenchTimings, RefusesAtTheDoorWhatItCannotCompareWith) {
  const auto says = [](const std::string& arguments) {
    const fs::path out = fs::path(testing::TempDir()) / "bench_timings_says.txt";
    const int status = std::system(
        fmt::format("'{}' bench {} >'{}' 2>&1", KESTREL_PROGRAM, arguments, out.string()).c_str());
    return fmt::format("{} {}", WEXITSTATUS(status), ReadFile(out));
  };
  const std::string none = says("timings --against /no/such/file");
  EXPECT_THAT(none, testing::StartsWith("2 "));
  EXPECT_THAT(none, HasSubstr("/no/such/file"));
  const std::string no_program = says("timings --against /bin/true");
  EXPECT_THAT(no_program, testing::StartsWith("2 "));
  EXPECT_THAT(no_program, HasSubstr("does not answer"));
  const std::string of_another_bench = says("speed --against /bin/true");
  EXPECT_THAT(of_another_bench, testing::StartsWith("2 "));
  EXPECT_THAT(of_another_bench, HasSubstr("--against"));
  EXPECT_THAT(says("limits --rounds 9 --seeds 1..2"),
              testing::AllOf(testing::StartsWith("2 "),
                             HasSubstr("--rounds is of no use to bench limits; valid: with timings"),
                             HasSubstr("--seeds is of no use")));
  EXPECT_THAT(says("timings --seeds 5..1"), HasSubstr("--seeds is of no use to bench timings"));
  const std::string empty = says("timings --against ''");
  EXPECT_THAT(empty, testing::StartsWith("2 "));
  EXPECT_THAT(empty, HasSubstr("no file"));
  const fs::path of_other_work = fs::path(testing::TempDir()) / "of_other_work";
  WriteFile(of_other_work, fmt::format(R"(#!/bin/sh
'{}' bench timings --in-turn </dev/null | sed 's/"work": *\[[^]]*\]/"work": ["another"]/'
while read -r work; do echo 1 1 1; done
)",
                                       KESTREL_PROGRAM));
  fs::permissions(of_other_work, fs::perms::owner_all);
  const std::string nothing_common =
      says(fmt::format("timings --rounds 9 --against '{}'", of_other_work.string()));
  EXPECT_THAT(nothing_common, testing::StartsWith("2 "));
  EXPECT_THAT(nothing_common, HasSubstr("none of its work"));
  const fs::path kept = fs::path(testing::TempDir()) / "of_other_work.json";
  const TimingRound round{{"another", {CalibratedBlock{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}}}};
  WriteFile(kept, ToJson({"old", ThisTimingMachine(), {round, round}}));
  const std::string nothing_kept = says(fmt::format("timings --against '{}'", kept.string()));
  EXPECT_THAT(nothing_kept, testing::StartsWith("2 "));
  EXPECT_THAT(nothing_kept, HasSubstr("none of its work"));
  EXPECT_THAT(says("timings --against /bin/true --json x.json"), HasSubstr("--json"));
}

}  // namespace
}  // namespace kestrel::bench
