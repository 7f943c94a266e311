// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/bench_timings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/own_program.h"
#include "base/process/status_line.h"
#include "base/statistics.h"
#include "base/user_file.h"

namespace kestrel::bench {
namespace {

namespace fs = std::filesystem;

TimingProgress ShownBy(StatusLine& line, int rounds) {
  return [&line, rounds](int round, const std::string& work) {
    line.Show(fmt::format("round {} of {}, {}", round + 1, rounds, work));
  };
}

std::string PieceOf(const std::string& name) {
  for (const TimedWork& work : AllTimedWork())
    if (work.name == name) return work.piece;
  return "piece";
}

// In the order of AllTimedWork.
template <class Row>
void Order(std::vector<Row>& rows) {
  const std::vector<TimedWork> all = AllTimedWork();
  std::stable_sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) {
    const auto place = [&](const Row& row) {
      return std::find_if(all.begin(), all.end(), [&](const TimedWork& w) { return w.name == row.work; });
    };
    return place(a) < place(b);
  });
}

bool PrintComparison(std::vector<SpeedRow> rows) {
  Order(rows);
  fmt::print("| {:<20} | {:<12} | {:>9} | {:>9} | {:>5} | {:<15} | {:<7} |\n", "work", "ms for each",
             "before", "now", "ratio", "interval", "verdict");
  fmt::print("|{:-<22}|{:-<14}|{:->10}:|{:->10}:|{:->6}:|{:-<17}|{:-<9}|\n", "", "", "", "", "", "", "");
  bool none_slower = true;
  for (const SpeedRow& row : rows) {
    const campaign::Estimate& e = row.ratio.ratio;
    fmt::print("| {:<20} | {:<12} | {:>9.3f} | {:>9.3f} | {:.3f} | {:<15} | {:<7} |\n", row.work,
               PieceOf(row.work), row.before_ms, row.now_ms, e.value,
               fmt::format("{:.3f} to {:.3f}", e.interval.low, e.interval.high), NameOf(row.ratio.verdict));
    none_slower = none_slower && row.ratio.verdict != SpeedVerdict::kSlower;
  }
  fmt::print(
      "Time now over time before; all intervals hold at once with {:.0f} %. Unclear: a change of {:.0f} % "
      "may "
      "be there or not.\n",
      100 * kTableLevel, 100 * kTold);
  return none_slower;
}

void PrintRecord(const TimingRecord& record, TimingClock clock) {
  struct Line {
    std::string work;
    std::vector<double> rounds;
  };
  std::vector<Line> lines;
  const auto add = [&](const std::string& name, auto&& time) {
    Line line{name, {}};
    for (const TimingRound& round : record.rounds) {
      std::vector<double> blocks;
      for (const auto& [work, all] : round)
        for (const CalibratedBlock& block : all)
          if (const WorkTimes* times = time(work, block)) blocks.push_back(PerPiece_ms(*times, clock));
      line.rounds.push_back(Quantile(blocks, 0.5));
    }
    lines.push_back(std::move(line));
  };
  for (const auto& [name, blocks] : record.rounds.front())
    add(name,
        [&](const std::string& work, const CalibratedBlock& b) { return work == name ? &b.work : nullptr; });
  add(kArithmetic, [](const std::string&, const CalibratedBlock& b) { return &b.arithmetic; });
  add(kMemory, [](const std::string&, const CalibratedBlock& b) { return &b.memory; });
  Order(lines);
  fmt::print("| {:<20} | {:<12} | {:>9} | {:>9} | {:>9} |\n", "work", "ms for each", "median", "fastest",
             "slowest");
  fmt::print("|{:-<22}|{:-<14}|{:->10}:|{:->10}:|{:->10}:|\n", "", "", "", "", "");
  for (const Line& line : lines)
    fmt::print("| {:<20} | {:<12} | {:>9.3f} | {:>9.3f} | {:>9.3f} |\n", line.work, PieceOf(line.work),
               Quantile(line.rounds, 0.5), Quantile(line.rounds, 0), Quantile(line.rounds, 1));
  fmt::print("Of {} processes, the median of each.\n", record.rounds.size());
}

// A program is a file that may be run; a run that was kept may not.
bool IsProgram(const fs::path& file) { return IsFile(file) && access(file.c_str(), X_OK) == 0; }

bool AgainstProgram(const TimingOptions& options) {
  if (!options.json.empty())
    throw InputError("--json", "keeps a run, and two programs in turn are none",
                     "valid: --json without --against, or with a run that was kept");
  InterleavedTimings timings;
  {
    StatusLine line("timings");
    timings = MeasureInterleaved(fs::absolute(options.against), OwnProgram(), options.rounds, options.clock,
                                 ShownBy(line, options.rounds));
  }
  fmt::print("before: {}\nnow:    {}\n", timings.version_before, timings.version_now);
  for (const std::string& work : timings.of_one_alone)
    fmt::print("{}: one of the two does not have it\n", work);
  return PrintComparison(Compare(timings));
}

TimingRecord ReadComparable(const fs::path& file) {
  Mistakes mistakes;
  const TimingRecord before = ReadTimingRecord(file, mistakes);
  if (mistakes.empty()) {
    const auto why = WhyNotComparable(before.machine, ThisTimingMachine());
    if (!why.empty())
      mistakes.Add(file.string(), "", fmt::format("times are not comparable: {}", fmt::join(why, "; ")),
                   "valid: a run of this machine and instruction set, or a program kestrel to run here");
    const std::vector<TimedWork> mine = AllTimedWork();
    if (std::none_of(mine.begin(), mine.end(),
                     [&](const TimedWork& work) { return before.rounds.front().contains(work.name); }))
      mistakes.Add(file.string(), "", "none of its work is what this program times",
                   "valid: a run of a nearer version");
  }
  mistakes.ThrowIfAny();
  return before;
}

}  // namespace

bool BenchTimings(const TimingOptions& options) {
  if (IsProgram(options.against)) return AgainstProgram(options);
  TimingRecord before, now;
  if (!options.against.empty()) before = ReadComparable(options.against);
  {
    StatusLine line("timings");
    now = MeasureTimings(OwnProgram(), options.rounds, ShownBy(line, options.rounds));
  }
  if (!options.json.empty()) WriteFile(options.json, ToJson(now));
  if (options.against.empty()) {
    PrintRecord(now, options.clock);
    return true;
  }
  fmt::print("before: {}\nnow:    {}\n", before.version, now.version);
  return PrintComparison(Compare(before, now, options.clock));
}

}  // namespace kestrel::bench
