// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/run_result.h"
#include "campaign/execution/worker_pool.h"
#include "campaign/tuning/tune_plan.h"

namespace kestrel::campaign {

// Flies, in any order and by however many workers, and gives the results in any order, one for each. A
// tuning's flights are counted from 0 in the order in which they are wanted (RunOrder::row), the same every
// time, so what was flown before an interruption can be answered from where it was kept.
using Fly = std::function<std::vector<RunResult>(const std::vector<RunOrder>&)>;

using Gains = std::map<std::string, double>;

// Gains, flown on some rows.
struct Evaluation {
  int round = 0;  // of the search; 0: the gains that it starts from
  Gains gains;
  std::int64_t flights = 0;   // until then, its own among them
  std::vector<double> costs;  // of each row, in their order
  std::vector<bool> passed;
  std::map<std::string, int> kept;  // flights that kept to a constraint, by its metric
  double Cost() const;              // their mean
};

// Of the costs of the same rows: the mean of after less before, with Student's 95 % interval.
struct PairedCost {
  double difference = 0, low = 0, high = 0;
};
PairedCost ComparePaired(const std::vector<double>& before, const std::vector<double>& after);

struct TuneResult {
  std::vector<Evaluation> search;   // in the order in which they were wanted
  bool compares_rounds = false;     // it flew them all on the same rows; otherwise each round on its own
  std::vector<Evaluation> leaders;  // the middle of where the search ended and the best of it, on fresh rows
  Gains gains;                      // of the leader that was best there
  std::int64_t flights = 0;         // of the budget
  Evaluation start, tuned;          // on the held-out rows
  std::optional<Evaluation> own;    // the scenario's own gains there, where the start is another
  PairedCost from_start;
  std::optional<PairedCost> from_own;
  bool Better() const { return from_start.high < 0; }
};

// Looks for the gains of lowest cost, on rows that all that is compared has in common: each round of a search
// on its own ones, so that it does not settle on what suits a few. Flies the best again on fresh ones, which
// are of the last rounds then, and what is best there, beside the gains it started from, on the held-out
// ones. Depends on the plan and the flights' results alone. progress: after each round.
TuneResult Tune(const LoadedTune& tune, const Fly& fly,
                const std::function<void(const TuneResult&)>& progress = {});

// How far a search had come after so many flights.
struct SearchStage {
  std::int64_t flights = 0;
  double cost = 0;
};
// After each round: the least cost until then, or, where rounds are not compared, the median of the round.
std::vector<SearchStage> Stages(const TuneResult& result);

// Of a gain, as a coordinate of the unit cube, and back.
double Coordinate(const Gain& gain, double value);
double ValueAt(const Gain& gain, double coordinate);

}  // namespace kestrel::campaign
