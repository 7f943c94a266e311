// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/speed_ratio.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/random.h"
#include "base/share_interval.h"

namespace kestrel::bench {
namespace {

constexpr int kRounds = 16, kBlocks = 5;
constexpr std::size_t kRows = 10;  // of a table

// A machine as a shared one is. Its speed wanders by a few percent from block to block, and by half over an hour; one
// block in twenty is broken into; and a process has a speed of its own, by the lie of its memory, one in ten by up to 8 %.
class Machine {
 public:
  explicit Machine(std::uint64_t seed) : random_(seed, "machine") {}
  double OfProcess() {
    const double far_off = random_.Uniform(0, 1) < 0.1 ? random_.Uniform(-0.08, 0.08) : 0;
    return 0.008 * random_.Normal() + far_off;
  }
  double Block_ms(double process, double work_ms) {
    speed_ = 0.995 * speed_ + 0.03 * random_.Normal();  // deviates by 0.3 in the long run
    const double broken_into = random_.Uniform(0, 1) < 0.05 ? random_.Uniform(0, 0.5) : 0;
    return work_ms * std::exp(speed_ + process + 0.01 * random_.Normal() + broken_into);
  }

 private:
  RandomStream random_;
  double speed_ = 0;
};

// Rounds of two builds in turn, of which the second takes so many times as long.
std::vector<double> InTurn(Machine& machine, double slower) {
  std::vector<double> rounds;
  for (int r = 0; r < kRounds; ++r) {
    const double a = machine.OfProcess(), b = machine.OfProcess();
    std::vector<BlockPair> blocks;
    for (int k = 0; k < kBlocks; ++k) {
      const double a_1 = machine.Block_ms(a, 10), b_1 = machine.Block_ms(b, 10 * slower),
                   b_2 = machine.Block_ms(b, 10 * slower), a_2 = machine.Block_ms(a, 10);
      blocks.push_back({std::sqrt(a_1 * a_2), std::sqrt(b_1 * b_2)});
    }
    rounds.push_back(LogRatioOf(blocks));
  }
  return rounds;
}

TEST(SpeedRatio, OfOneBuildIsOneAsOftenAsTheLevelSays) {
  constexpr int kTables = 400;
  int alarms = 0, at_95 = 0;
  for (int i = 0; i < kTables; ++i) {
    Machine machine(static_cast<std::uint64_t>(i));
    const std::vector<double> rounds = InTurn(machine, 1);
    alarms += !RatioOf(rounds, LevelOfEach(kRows)).ratio.interval.Holds(1);
    at_95 += !RatioOf(rounds, 0.95).ratio.interval.Holds(1);
  }
  // Rows of a table: one in 200 may be wrong. Without the table's level, one in twenty may be, and some are.
  EXPECT_LE(ShareAtLeast(alarms, kTables, 0.999), 1 - LevelOfEach(kRows));
  EXPECT_LE(ShareAtLeast(at_95, kTables, 0.999), 0.05);
  EXPECT_GT(at_95, 0);
}

TEST(SpeedRatio, FivePercentAreSeenInAMachineThatDriftsByHalf) {
  constexpr int kTables = 200;
  int slower = 0, faster = 0;
  double value = 0;
  for (int i = 0; i < kTables; ++i) {
    Machine machine(1000 + static_cast<std::uint64_t>(i));
    const SpeedRatio up = RatioOf(InTurn(machine, 1.05), LevelOfEach(kRows));
    slower += up.verdict == SpeedVerdict::kSlower;
    value += up.ratio.value / kTables;
    faster += RatioOf(InTurn(machine, 1 / 1.05), LevelOfEach(kRows)).verdict == SpeedVerdict::kFaster;
  }
  EXPECT_GE(slower, 0.95 * kTables);
  EXPECT_GE(faster, 0.95 * kTables);
  EXPECT_NEAR(value, 1.05, 0.005);
}

TEST(SpeedRatio, OneAfterTheOtherTheSameDriftHidesThem) {
  // What blocks in turn are for: the same machine, first all of one build, then all of the other.
  int slower = 0;
  for (int i = 0; i < 100; ++i) {
    Machine machine(2000 + static_cast<std::uint64_t>(i));
    const auto all_of = [&](double work_ms) {
      std::vector<double> logs;
      for (int r = 0; r < kRounds; ++r) {
        const double process = machine.OfProcess();
        std::vector<BlockPair> blocks;
        for (int k = 0; k < 2 * kBlocks; ++k) blocks.push_back({1, machine.Block_ms(process, work_ms)});
        logs.push_back(LogRatioOf(blocks));
      }
      return logs;
    };
    const std::vector<double> before = all_of(10);
    std::vector<double> differences = all_of(10.5);
    for (int r = 0; r < kRounds; ++r)
      differences[static_cast<std::size_t>(r)] -= before[static_cast<std::size_t>(r)];
    slower += RatioOf(differences, LevelOfEach(kRows)).verdict == SpeedVerdict::kSlower;
  }
  EXPECT_LT(slower, 50);
}

// Rounds that scatter so much about a log ratio.
std::vector<double> Rounds(double about, double by) {
  std::vector<double> rounds;
  for (int i = -4; i <= 4; ++i) rounds.push_back(about + by * i / 4);
  return rounds;
}

TEST(SpeedRatio, VerdictsTellWhatIsNotKnownFromWhatIsTheSame) {
  EXPECT_EQ(RatioOf(Rounds(0.001, 0.01), 0.95).verdict, SpeedVerdict::kSame);
  EXPECT_EQ(RatioOf(Rounds(0.001, 0.1), 0.95).verdict, SpeedVerdict::kUnclear);
  EXPECT_EQ(RatioOf(Rounds(0.1, 0.05), 0.95).verdict, SpeedVerdict::kSlower);
  EXPECT_EQ(RatioOf(Rounds(-0.1, 0.05), 0.95).verdict, SpeedVerdict::kFaster);
}

TEST(SpeedRatio, OfTooFewRoundsNothingFollows) {
  EXPECT_EQ(RatioOf({0.1, 0.1, 0.1}, 0.95).verdict, SpeedVerdict::kUnclear);
}

TEST(SpeedRatio, OneBlockThatWasBrokenIntoDoesNotMatter) {
  EXPECT_DOUBLE_EQ(LogRatioOf({{10, 11}, {20, 22}, {10, 50}}), std::log(1.1));
}

TEST(SpeedRatio, TheWidestIsNoAlarmIfOneOfTheAnswersIsNone) {
  const SpeedRatio by_one = RatioOf(Rounds(0.1, 0.05), 0.95), by_other = RatioOf(Rounds(0, 0.01), 0.95);
  const SpeedRatio both = Widest({by_one, by_other});
  EXPECT_EQ(both.ratio.interval.low, by_other.ratio.interval.low);
  EXPECT_EQ(both.ratio.interval.high, by_one.ratio.interval.high);
  EXPECT_EQ(both.verdict, SpeedVerdict::kUnclear);
}

TEST(SpeedRatio, ATableOfMoreRowsAsksForMoreOfEach) {
  EXPECT_DOUBLE_EQ(LevelOfEach(1), 0.95);
  EXPECT_DOUBLE_EQ(LevelOfEach(10), 0.995);
}

}  // namespace
}  // namespace kestrel::bench
