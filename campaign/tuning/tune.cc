// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <utility>

#include "base/statistics.h"
#include "campaign/statistics/paired.h"
#include "campaign/tuning/search.h"

namespace kestrel::campaign {
namespace {

class Tuning {
 public:
  Tuning(const LoadedTune& tune, const Fly& fly) : tune_(tune), plan_(tune.plan), fly_(fly) {}

  TuneResult Run(const std::function<void(const TuneResult&)>& progress) {
    const auto show = [&] {
      if (progress) progress(result_);
    };
    Gains start;
    for (const auto& [key, gain] : plan_.gains) start[key] = *gain.start;
    const SampleTable first_rows = RowsOfRound(plan_, 0);
    result_.search = Evaluate(0, {start}, first_rows);
    Search search = MakeSearch(plan_.method, PointOf(start), plan_.flights.seed);
    result_.compares_rounds = ComparesRounds(search);
    show();
    const auto for_leaders = static_cast<std::int64_t>(plan_.leaders * tune_.fresh.rows.size());
    for (int round = 1;; ++round) {
      std::vector<Gains> candidates;
      for (const Point& point : std::visit([](auto& s) { return s.Ask(); }, search))
        candidates.push_back(GainsAt(point));
      const auto flights = static_cast<std::int64_t>(candidates.size() * first_rows.rows.size());
      if (flights_ + flights + for_leaders > plan_.budget) break;
      std::vector<Evaluation> evaluations =
          Evaluate(round, candidates, result_.compares_rounds ? first_rows : RowsOfRound(plan_, round));
      std::vector<double> costs;
      for (const Evaluation& e : evaluations) costs.push_back(e.Cost());
      std::visit([&](auto& s) { s.Tell(costs); }, search);
      result_.search.insert(result_.search.end(), evaluations.begin(), evaluations.end());
      show();
    }
    FlyLeaders(GainsAt(std::visit([](auto& s) { return s.Centre(); }, search)));
    show();
    HoldOut(start);
    return result_;
  }

 private:
  Point PointOf(const Gains& gains) const {
    Point point;
    for (const auto& [key, gain] : plan_.gains) point.push_back(Coordinate(gain, gains.at(key)));
    return point;
  }
  Gains GainsAt(const Point& point) const {
    Gains gains;
    std::size_t i = 0;
    for (const auto& [key, gain] : plan_.gains) gains[key] = ValueAt(gain, point[i++]);
    return gains;
  }

  std::vector<Evaluation> Evaluate(int round, const std::vector<Gains>& candidates,
                                   const SampleTable& table) {
    const std::size_t rows = table.rows.size();
    const std::int64_t first = flights_;
    std::vector<RunOrder> orders;
    for (const Gains& gains : candidates) {
      for (std::size_t row = 0; row < rows; ++row) {
        RunOrder order{flights_++, plan_.flights.scenario, plan_.flights.set, std::nullopt, false};
        for (std::string& each : OverridesOf(table, row)) order.overrides.push_back(std::move(each));
        for (const auto& [key, value] : gains) order.overrides.push_back(fmt::format("{}={}", key, value));
        orders.push_back(std::move(order));
      }
    }
    std::vector<RunResult> results = fly_(orders);
    assert(results.size() == orders.size());
    std::sort(results.begin(), results.end(), [](const auto& a, const auto& b) { return a.row < b.row; });
    std::vector<Evaluation> evaluations;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      Evaluation e{round, candidates[c], first + static_cast<std::int64_t>((c + 1) * rows), {}, {}, {}};
      for (std::size_t row = 0; row < rows; ++row) {
        const RunResult& result = results[c * rows + row];
        e.costs.push_back(CostOf(result, plan_.cost));
        e.passed.push_back(result.status == RunStatus::kPassed);
        for (const auto& [metric, constraint] : plan_.cost.constraints)
          e.kept[metric] += Keeps(result, metric, constraint);
      }
      evaluations.push_back(std::move(e));
    }
    return evaluations;
  }

  // The best first; of rounds that are not compared, the best of each from the last to the first, then the
  // second best of each, and so on.
  std::vector<Gains> BestOfSearch() const {
    std::vector<double> costs;
    for (const Evaluation& e : result_.search) costs.push_back(e.Cost());
    std::vector<std::size_t> order = ByCost(costs);
    if (!result_.compares_rounds) {
      std::map<int, int> seen;            // of each round
      std::map<std::size_t, int> behind;  // so many of its own
      for (const std::size_t i : order) behind[i] = seen[result_.search[i].round]++;
      std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(behind[a], -result_.search[a].round) <
               std::pair(behind[b], -result_.search[b].round);
      });
    }
    std::vector<Gains> best;
    for (const std::size_t i : order) best.push_back(result_.search[i].gains);
    return best;
  }

  void FlyLeaders(const Gains& centre) {
    std::vector<Gains> leaders = {centre};
    for (const Gains& gains : BestOfSearch()) {
      if (static_cast<int>(leaders.size()) == plan_.leaders) break;
      if (std::find(leaders.begin(), leaders.end(), gains) == leaders.end()) leaders.push_back(gains);
    }
    result_.leaders = Evaluate(result_.search.back().round, leaders, tune_.fresh);
    result_.flights = flights_;
    std::vector<double> costs;
    for (const Evaluation& e : result_.leaders) costs.push_back(e.Cost());
    result_.gains = result_.leaders[ByCost(costs).front()].gains;
  }

  void HoldOut(const Gains& start) {
    std::vector<Gains> candidates = {start, result_.gains};
    if (tune_.own.size() == start.size() && tune_.own != start) candidates.push_back(tune_.own);
    std::vector<Evaluation> evaluations = Evaluate(0, candidates, tune_.held_out);
    result_.start = evaluations[0], result_.tuned = evaluations[1];
    result_.from_start = ComparePaired(result_.start.costs, result_.tuned.costs);
    if (candidates.size() < 3) return;
    result_.own = evaluations[2];
    result_.from_own = ComparePaired(result_.own->costs, result_.tuned.costs);
  }

  const LoadedTune& tune_;
  const TunePlan& plan_;
  const Fly& fly_;
  std::int64_t flights_ = 0;
  TuneResult result_;
};

}  // namespace

double Evaluation::Cost() const {
  return std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(costs.size());
}

PairedCost ComparePaired(const std::vector<double>& before, const std::vector<double>& after) {
  assert(before.size() == after.size() && before.size() > 1);
  std::vector<double> differences;
  for (std::size_t i = 0; i < before.size(); ++i) differences.push_back(after[i] - before[i]);
  const Interval interval = StudentInterval(differences);
  return {Mean(differences), interval.low, interval.high};
}

std::vector<SearchStage> Stages(const TuneResult& result) {
  std::map<int, std::vector<const Evaluation*>> rounds;
  for (const Evaluation& e : result.search) rounds[e.round].push_back(&e);
  std::vector<SearchStage> stages;
  for (const auto& [number, round] : rounds) {
    std::vector<double> costs;
    for (const Evaluation* e : round) costs.push_back(e->Cost());
    double cost = Quantile(costs, result.compares_rounds ? 0 : 0.5);
    if (result.compares_rounds && !stages.empty()) cost = std::min(cost, stages.back().cost);
    stages.push_back({round.back()->flights, cost});
  }
  return stages;
}

double Coordinate(const Gain& gain, double value) {
  return gain.log ? std::log(value / gain.low) / std::log(gain.high / gain.low)
                  : (value - gain.low) / (gain.high - gain.low);
}

double ValueAt(const Gain& gain, double coordinate) {
  const double value = gain.log ? gain.low * std::exp(coordinate * std::log(gain.high / gain.low))
                                : gain.low + coordinate * (gain.high - gain.low);
  // As few digits as people can read in the file of the gains.
  return std::clamp(std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr), gain.low, gain.high);
}

TuneResult Tune(const LoadedTune& tune, const Fly& fly,
                const std::function<void(const TuneResult&)>& progress) {
  return Tuning(tune, fly).Run(progress);
}

}  // namespace kestrel::campaign
