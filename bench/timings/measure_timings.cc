// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/measure_timings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "base/diagnostics.h"
#include "base/statistics.h"

namespace kestrel::bench {
namespace {

int BlocksOf(const std::string& name) {
  for (const TimedWork& work : AllTimedWork())
    if (work.name == name) return work.blocks;
  return TimedWork().blocks;
}

int MostBlocks(const std::vector<std::string>& names) {
  int most = 0;
  for (const std::string& name : names) most = std::max(most, BlocksOf(name));
  return most;
}

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

double Median(const std::vector<double>& values) { return Quantile(values, 0.5); }

}  // namespace

double PerPiece_ms(const WorkTimes& times, TimingClock clock) {
  return (clock == TimingClock::kWall ? times.wall_ms : times.processor_ms) / times.pieces;
}

TimingRecord MeasureTimings(const std::filesystem::path& program, int rounds, const TimingProgress& show) {
  TimingRecord record;
  for (int r = 0; r < rounds; ++r) {
    TimedProgram process(program);
    record.version = process.version(), record.machine = process.machine();
    TimingRound round;
    for (int k = -1; k < MostBlocks(process.work()); ++k)
      for (const std::string& work : process.work()) {
        if (work == kArithmetic || work == kMemory || k >= BlocksOf(work)) continue;
        show(r, work);
        const CalibratedBlock block{
            .work = {}, .arithmetic = process.Time(kArithmetic), .memory = process.Time(kMemory)};
        const WorkTimes times = process.Time(work);
        if (k < 0) continue;  // which made what it needs
        round[work].push_back(block);
        round[work].back().work = times;
      }
    record.rounds.push_back(std::move(round));
  }
  return record;
}

InterleavedTimings MeasureInterleaved(const std::filesystem::path& before, const std::filesystem::path& now,
                                      int rounds, TimingClock clock, const TimingProgress& show) {
  InterleavedTimings timings;
  for (int r = 0; r < rounds; ++r) {
    // Which of the two began first may matter for where its memory lies.
    std::unique_ptr<TimedProgram> a, b;
    const auto begin = [](std::unique_ptr<TimedProgram>& one, const std::filesystem::path& program) {
      one = std::make_unique<TimedProgram>(program);
    };
    if (r % 2 == 0)
      begin(a, before), begin(b, now);
    else
      begin(b, now), begin(a, before);
    if (r == 0) {
      timings.version_before = a->version(), timings.version_now = b->version();
      const auto why = WhyNotComparable(a->machine(), b->machine());
      if (!why.empty())
        throw InputError(before.string(), fmt::format("times are not comparable: {}", fmt::join(why, "; ")),
                         "valid: a program that goes by the same instruction set");
      for (const std::string& work : b->work())
        if (!Has(a->work(), work)) timings.of_one_alone.push_back(work);
      for (const std::string& work : a->work())
        if (!Has(b->work(), work)) timings.of_one_alone.push_back(work);
      if (timings.of_one_alone.size() == a->work().size() + b->work().size())
        throw InputError(before.string(), "none of its work is what this program times",
                         "valid: a build of a nearer version");
    }
    std::map<std::string, std::vector<BlockPair>> of_round;
    for (int k = -1; k < MostBlocks(b->work()); ++k)
      for (const std::string& work : b->work()) {
        if (!Has(a->work(), work) || k >= BlocksOf(work)) continue;
        show(r, work);
        if (k < 0) {
          a->Time(work), b->Time(work);
          continue;
        }
        const bool now_first = (k + r) % 2 == 1;
        TimedProgram &first = now_first ? *b : *a, &second = now_first ? *a : *b;
        const auto time = [&](TimedProgram& one) { return PerPiece_ms(one.Time(work), clock); };
        const double first_1 = time(first), second_1 = time(second), second_2 = time(second),
                     first_2 = time(first);
        const double of_first = std::sqrt(first_1 * first_2), of_second = std::sqrt(second_1 * second_2);
        of_round[work].push_back(now_first ? BlockPair{of_second, of_first} : BlockPair{of_first, of_second});
      }
    for (auto& [work, pairs] : of_round) timings.pairs[work].push_back(std::move(pairs));
  }
  return timings;
}

std::vector<SpeedRow> Compare(const InterleavedTimings& timings) {
  std::vector<SpeedRow> rows;
  for (const auto& [work, rounds] : timings.pairs) {
    std::vector<double> ratios, before, now;
    for (const std::vector<BlockPair>& pairs : rounds) {
      ratios.push_back(LogRatioOf(pairs));
      std::vector<double> a, b;
      for (const BlockPair& pair : pairs) a.push_back(pair.before), b.push_back(pair.now);
      before.push_back(Median(a)), now.push_back(Median(b));
    }
    rows.push_back({work, Median(before), Median(now), RatioOf(ratios, LevelOfEach(timings.pairs.size()))});
  }
  return rows;
}

std::vector<SpeedRow> Compare(const TimingRecord& before, const TimingRecord& now, TimingClock clock) {
  std::vector<std::string> both;
  for (const auto& [work, blocks] : now.rounds.front())
    if (before.rounds.front().contains(work)) both.push_back(work);
  const std::size_t rounds = std::min(before.rounds.size(), now.rounds.size());
  std::vector<SpeedRow> rows;
  for (const std::string& work : both) {
    const auto median = [&](const TimingRecord& record) {
      std::vector<double> all;
      for (const TimingRound& round : record.rounds)
        for (const CalibratedBlock& block : round.at(work)) all.push_back(PerPiece_ms(block.work, clock));
      return Median(all);
    };
    std::vector<SpeedRatio> answers;
    for (const auto calibration : {&CalibratedBlock::arithmetic, &CalibratedBlock::memory}) {
      const auto of = [&](const TimingRound& round) {
        std::vector<BlockPair> by_calibration;
        for (const CalibratedBlock& block : round.at(work))
          by_calibration.push_back({PerPiece_ms(block.*calibration, clock), PerPiece_ms(block.work, clock)});
        return LogRatioOf(by_calibration);
      };
      std::vector<double> differences;
      for (std::size_t r = 0; r < rounds; ++r)
        differences.push_back(of(now.rounds[r]) - of(before.rounds[r]));
      answers.push_back(RatioOf(differences, LevelOfEach(both.size())));
    }
    rows.push_back({work, median(before), median(now), Widest(answers)});
  }
  return rows;
}

}  // namespace kestrel::bench
