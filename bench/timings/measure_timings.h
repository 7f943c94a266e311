// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bench/timings/speed_ratio.h"
#include "bench/timings/timed_program.h"
#include "bench/timings/timing_record.h"

namespace kestrel::bench {

// What a program's work is timed by.
enum class TimingClock { kProcessor, kWall };
double PerPiece_ms(const WorkTimes& times, TimingClock clock);

// Is told what is under way.
using TimingProgress = std::function<void(int round, const std::string& work)>;

// A new process of the program for each round. Throws as TimedProgram does.
TimingRecord MeasureTimings(const std::filesystem::path& program, int rounds, const TimingProgress& show);

// For each work that both programs have, by its name, and each round: blocks of both in turn, A B B A and B A A B.
struct InterleavedTimings {
  std::string version_before, version_now;
  std::map<std::string, std::vector<std::vector<BlockPair>>> pairs;  // ms a piece
  std::vector<std::string> of_one_alone;                             // work that the other does not have
};
// Throws as TimedProgram does, and InputError: they are of different instruction sets, or time no work of one name.
InterleavedTimings MeasureInterleaved(const std::filesystem::path& before, const std::filesystem::path& now,
                                      int rounds, TimingClock clock, const TimingProgress& show);

// A line of the table.
struct SpeedRow {
  std::string work;
  double before_ms = 0, now_ms = 0;  // a piece, median of the rounds' medians
  SpeedRatio ratio;
};
std::vector<SpeedRow> Compare(const InterleavedTimings& timings);
// Of two runs: ratios by either calibration, as the wider of both says. The rounds are independent: they are paired as
// they come. Work that both have.
std::vector<SpeedRow> Compare(const TimingRecord& before, const TimingRecord& now, TimingClock clock);

}  // namespace kestrel::bench
