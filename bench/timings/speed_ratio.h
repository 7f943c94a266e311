// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "campaign/statistics/intervals.h"

namespace kestrel::bench {

// What is measured is drawn from three sources: what the machine does beside, which drifts and is common to what is timed
// within a second; blocks that something broke into; and a process, which by the lie of its memory is faster or slower
// than another of the same program, all its life, now and then by much. So blocks are compared with their neighbours
// (logarithms, so that a drift cancels), a process's answer is the median over its blocks, and the answer of all is the
// median over processes, with the interval that holds it whatever they are drawn from.

// A block of either build, of the same work, or a block and the calibration beside it: times of anything.
struct BlockPair {
  double before = 0, now = 0;
};
// Of one process of either: log(now / before).
double LogRatioOf(const std::vector<BlockPair>& blocks);

enum class SpeedVerdict {
  kSame,     // the interval has 1, and neither end is further off than kTold
  kSlower,   // all of it lies above 1
  kFaster,   // all of it lies below
  kUnclear,  // it has 1, and is too wide to say that nothing changed by kTold
};
inline constexpr double kTold = 0.05;
const char* NameOf(SpeedVerdict verdict);

// Time now over time before.
struct SpeedRatio {
  campaign::Estimate ratio;
  SpeedVerdict verdict = SpeedVerdict::kUnclear;
};

// All intervals of a table hold at once with this probability.
inline constexpr double kTableLevel = 0.95;
double LevelOfEach(std::size_t rows);

// rounds: log ratios, one for each pair of processes, at least one; of too few for the level the interval has no ends.
SpeedRatio RatioOf(const std::vector<double>& rounds, double level);
// Of several answers to one question of which none is known to be right: their interval is from the lowest end to the
// highest. At least one.
SpeedRatio Widest(const std::vector<SpeedRatio>& answers);

}  // namespace kestrel::bench
