// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/tune.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/random.h"
#include "base/statistics.h"
#include "campaign/table/sampling.h"
#include "campaign/tuning/tune_files.h"
#include "campaign/tuning/tune_report.h"

namespace kestrel::campaign {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pair;
using ::testing::SizeIs;

std::map<std::string, double> ValuesOf(const RunOrder& order) {
  std::map<std::string, double> value;
  for (const std::string& each : order.overrides)
    value[each.substr(0, each.find('='))] = std::stod(each.substr(each.find('=') + 1));
  return value;
}

// What chance the row has.
RandomStream ChanceOf(const std::map<std::string, double>& value) {
  return {static_cast<std::uint64_t>(std::fmod(value.at("seed"), 1e15)), "formula"};
}

// Flights that are a formula: least error at the gains 2, 0.5, 0.3 and 0.7, with a part that is the row's.
RunResult Formula(const RunOrder& order) {
  std::map<std::string, double> value = ValuesOf(order);
  RunResult result{order.row, RunStatus::kPassed, "", {}, "", "", {}};
  RandomStream random = ChanceOf(value);
  const double a = std::log(value["gain.a"] / 2), b = value["gain.b"] - 0.5;
  result.metrics["error_m"] =
      (a * a + 4 * b * b) * (1 + 0.3 * random.Normal()) + 0.1 * value["wind"] + 0.05 * random.Normal() + 1;
  if (value["gain.a"] > 9) result.status = RunStatus::kFailed;
  return result;
}

std::vector<RunResult> FlyFormula(const std::vector<RunOrder>& orders) {
  std::vector<RunResult> results;
  for (const RunOrder& order : orders) results.push_back(Formula(order));
  return results;
}

LoadedTune Problem(std::uint64_t seed = 1) {
  LoadedTune tune;
  TunePlan& plan = tune.plan;
  plan.flights.name = "formula";
  plan.flights.scenario = "none";
  plan.flights.set = {"fixed=1"};
  plan.flights.vary = {{"wind", Uniform{0, 1}}};
  plan.flights.seed = seed;
  plan.gains["gain.a"] = {0.1, 10, true, 9.5};
  plan.gains["gain.b"] = {0, 1, false, 0.0};
  plan.gains["gain.c"] = plan.gains["gain.d"] = {0, 1, false, 0.0};
  plan.rows = 3;
  plan.cost.terms["error_m"] = {1, 1, 50, {}};
  tune.own = {{"gain.a", 3}, {"gain.b", 0.4}, {"gain.c", 0.5}, {"gain.d", 0.5}};
  const auto draw = [&](int runs, const char* name) {
    CampaignPlan flights = plan.flights;
    flights.runs = runs, flights.seed = RandomStream(seed, name).Bits();
    return DrawTable(flights);
  };
  tune.fresh = draw(plan.fresh_rows, "fresh");
  tune.held_out = draw(plan.held_out_rows, "held out");
  return tune;
}

TEST(Tune, ItFindsGainsThatHoldOnRowsThatTheSearchNeverSaw) {
  const LoadedTune tune = Problem();
  const TuneResult result = Tune(tune, FlyFormula);
  EXPECT_NEAR(std::log(result.gains.at("gain.a") / 2), 0, 0.3);
  EXPECT_NEAR(result.gains.at("gain.b"), 0.5, 0.15);
  EXPECT_LE(result.flights, 500);
  EXPECT_GT(result.flights, 500 - 8 * 3);  // less than a round is left over
  EXPECT_THAT(result.start.costs, SizeIs(50));
  EXPECT_THAT(result.start.passed, Each(false));
  EXPECT_THAT(result.tuned.passed, Each(true));
  EXPECT_TRUE(result.Better());
  // Those that the scenario had are better than the start, and worse than these.
  ASSERT_TRUE(result.from_own);
  EXPECT_GT(result.from_own->difference, result.from_start.difference);
  EXPECT_LT(result.from_own->high, 0);
}

TEST(Tune, CmaEsIsAheadOfTheOthersInTheMedianOfItsHeldOutCost) {
  const auto median = [](const char* method) {
    std::vector<double> costs;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      LoadedTune tune = Problem(seed);
      tune.plan.method = method;
      costs.push_back(Tune(tune, FlyFormula).tuned.Cost());
    }
    std::nth_element(costs.begin(), costs.begin() + 2, costs.end());
    return costs[2];
  };
  const double cma_es = median("cma_es");
  EXPECT_LE(cma_es, median("cross_entropy"));
  EXPECT_LE(cma_es, median("random_search"));
}

std::vector<double> Held(const TuneResult& result) {
  std::vector<double> all = result.tuned.costs;
  for (const Evaluation& e : result.search) all.insert(all.end(), e.costs.begin(), e.costs.end());
  for (const auto& [key, value] : result.gains) all.push_back(value);
  return all;
}

TEST(Tune, TheOrderInWhichFlightsEndChangesNothing) {
  const LoadedTune tune = Problem();
  const auto backwards = [](const std::vector<RunOrder>& orders) {
    std::vector<RunResult> results = FlyFormula(orders);
    std::reverse(results.begin(), results.end());
    return results;
  };
  EXPECT_EQ(Held(Tune(tune, backwards)), Held(Tune(tune, FlyFormula)));
}

TEST(Tune, InterruptedItGoesOnFromTheFlightsThatWereKept) {
  const LoadedTune tune = Problem();
  const std::vector<double> whole = Held(Tune(tune, FlyFormula));
  std::map<std::int64_t, RunResult> kept;
  int flown = 0, runs = 0;
  for (bool done = false; !done; ++runs) {
    int left = 97;  // of this process, until it is killed amid a round
    const auto fly = [&](const std::vector<RunOrder>& orders) {
      std::vector<RunResult> results;
      for (const RunOrder& order : orders) {
        if (!kept.contains(order.row)) {
          if (left-- == 0) throw std::runtime_error("killed");
          kept[order.row] = Formula(order), ++flown;
        }
        results.push_back(kept.at(order.row));
      }
      return results;
    };
    try {
      EXPECT_EQ(Held(Tune(tune, fly)), whole);
      done = true;
    } catch (const std::runtime_error&) {}
  }
  EXPECT_GT(runs, 5);
  EXPECT_EQ(flown, static_cast<int>(kept.size()));  // nothing twice
}

// By the seed of each row that a tuning flies, the gains that were flown on it.
std::map<std::string, std::set<std::string>> GainsOfRows(const LoadedTune& tune, TuneResult& result) {
  std::map<std::string, std::set<std::string>> gains_of_seed;
  std::int64_t next = 0;
  const auto fly = [&](const std::vector<RunOrder>& orders) {
    for (const RunOrder& order : orders) {
      EXPECT_EQ(order.row, next++);
      EXPECT_EQ(order.overrides[0], "fixed=1");
      EXPECT_THAT(order.overrides, SizeIs(7));
      gains_of_seed[order.overrides[1]].insert(order.overrides[3] + order.overrides[4] + order.overrides[5] +
                                               order.overrides[6]);
    }
    return FlyFormula(orders);
  };
  result = Tune(tune, fly);
  return gains_of_seed;
}

TEST(Tune, ARoundsCandidatesFlyTheSameRowsAndNoOtherRoundDoes) {
  TuneResult result;
  const auto gains_of_seed = GainsOfRows(Problem(), result);
  const auto rounds = static_cast<std::size_t>(result.search.back().round);
  EXPECT_GT(rounds, 10u);
  EXPECT_THAT(gains_of_seed, SizeIs(3 * (1 + rounds) + 10 + 50));
  std::map<std::size_t, std::size_t> rows_of_so_many;
  for (const auto& [seed, gains] : gains_of_seed) ++rows_of_so_many[gains.size()];
  // The start; those held out: start, tuned, own; the fresh ones: five leaders; eight of each round.
  EXPECT_THAT(rows_of_so_many, ElementsAre(Pair(1, 3), Pair(3, 50), Pair(5, 10), Pair(8, 3 * rounds)));
}

TEST(Tune, ASearchThatComparesItsRoundsFliesThemOnTheSameRows) {
  LoadedTune tune = Problem();
  tune.plan.method = "random_search";
  TuneResult result;
  const auto gains_of_seed = GainsOfRows(tune, result);
  EXPECT_THAT(gains_of_seed, SizeIs(3 + 10 + 50));
  std::set<std::size_t> sizes;
  for (const auto& [seed, gains] : gains_of_seed) sizes.insert(gains.size());
  EXPECT_THAT(sizes, ElementsAre(3, 5, result.search.size()));  // held out, fresh, of the search
  EXPECT_THAT(Stages(result), SizeIs(1 + result.search.back().round));
  EXPECT_EQ(Stages(result).back().cost,
            std::min_element(result.search.begin(), result.search.end(), [](const auto& a, const auto& b) {
              return a.Cost() < b.Cost();
            })->Cost());
}

// The costs of different rounds are of different rows: the least of all is of the easiest row.
TEST(Tune, LeadersAreTheMiddleOfTheSearchAndTheBestOfItsLastRounds) {
  const TuneResult result = Tune(Problem(), FlyFormula);
  ASSERT_THAT(result.leaders, SizeIs(5));
  std::map<int, const Evaluation*> best;
  for (const Evaluation& e : result.search)
    if (!best.contains(e.round) || e.Cost() < best.at(e.round)->Cost()) best[e.round] = &e;
  auto round = best.rbegin();
  for (std::size_t i = 1; i < 5; ++i, ++round) EXPECT_EQ(result.leaders[i].gains, round->second->gains);
}

// Every row has gains of its own that suit it best; what suits all is the middle of those.
TEST(Tune, ItDoesNotSettleOnWhatSuitsAFewRows) {
  const auto fly = [](const std::vector<RunOrder>& orders) {
    std::vector<RunResult> results;
    for (const RunOrder& order : orders) {
      std::map<std::string, double> value = ValuesOf(order);
      RunResult result{order.row, RunStatus::kPassed, "", {}, "", "", {}};
      RandomStream row = ChanceOf(value);
      double sum = 0;
      for (const char* key : {"gain.b", "gain.c", "gain.d"})
        sum += std::pow(value[key] - 0.5 - 0.3 * row.Normal(), 2);
      result.metrics["error_m"] = sum;
      results.push_back(result);
    }
    return results;
  };
  std::vector<double> off;
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    LoadedTune tune = Problem(seed);
    tune.plan.gains.erase("gain.a"), tune.plan.rows = 1;
    const TuneResult result = Tune(tune, fly);
    double squares = 0;
    for (const auto& [key, value] : result.gains) squares += std::pow(value - 0.5, 2);
    off.push_back(std::sqrt(squares / 3));
  }
  // Were every candidate flown on the same row, the row's own best would be found, 0.3 off; 15 fresh ones
  // tell leaders apart that differ by 0.1.
  EXPECT_LT(Quantile(off, 0.5), 0.15);
}

TEST(Tune, AConstraintThatIsNotMetIsSaidWhereverTheVerdictIs) {
  const auto said = [](double most) {
    LoadedTune tune = Problem();
    tune.plan.cost.constraints["error_m"] = {most, {}, 5};
    const TuneResult result = Tune(tune, FlyFormula);
    return std::tuple(TuneText(tune, result), GainsFile(tune, result, "f.yaml", "1.0"),
                      ComparisonText({{tune, result, {}}, {tune, result, {}}}));
  };
  const auto [never, never_file, never_beside] = said(-100);
  EXPECT_THAT(never, HasSubstr("No candidate met the constraint on error_m (at most -100) in any flight."));
  EXPECT_THAT(never_file, HasSubstr("\n# No candidate met the constraint on error_m (at most -100) in any"));
  EXPECT_THAT(never_beside, testing::ContainsRegex("CMA-ES, seed 1: No candidate met .*\n"
                                                   "CMA-ES, seed 1: No candidate met .*\n$"));
  const auto [some, some_file, some_beside] = said(1.06);
  EXPECT_THAT(some,
              testing::ContainsRegex("met the constraint on error_m .at most 1.06. in [0-9]+ of 50 flights"));
  EXPECT_THAT(some_beside, HasSubstr("CMA-ES, seed 1: The tuned gains met"));
  const auto [always, always_file, always_beside] = said(100);
  EXPECT_THAT(always + always_file + always_beside, Not(HasSubstr("constraint")));
}

TEST(Tune, ACostThatNoGainChangesIsSaid) {
  LoadedTune tune = Problem();
  EXPECT_THAT(VerdictText(tune, Tune(tune, FlyFormula)), Not(HasSubstr("cost the same")));
  tune.plan.cost.terms["error_m"].weight = 0, tune.plan.cost.failure = 0;
  for (const char* method : {"cma_es", "random_search"}) {
    tune.plan.method = method;
    EXPECT_THAT(VerdictText(tune, Tune(tune, FlyFormula)),
                HasSubstr("All candidates of the search cost the same"));
  }
}

TEST(Tune, AGainThatEndsAtItsBoundIsMarked) {
  LoadedTune tune = Problem();
  TuneResult result = Tune(tune, FlyFormula);
  EXPECT_THAT(TuneText(tune, result), Not(testing::ContainsRegex("gain.a .* its bound")));
  result.gains["gain.a"] = 10;
  EXPECT_THAT(TuneText(tune, result), testing::ContainsRegex("gain.a .* its bound"));
  EXPECT_THAT(GainsFile(tune, result, "f.yaml", "1.0"), HasSubstr("gain.a: 10  # began at 9.5; a bound"));
}

TEST(Tune, TheBestOfTheSearchIsJudgedOnFreshRows) {
  const TuneResult result = Tune(Problem(), FlyFormula);
  ASSERT_THAT(result.leaders, SizeIs(5));
  const auto best = std::min_element(result.leaders.begin(), result.leaders.end(),
                                     [](const auto& a, const auto& b) { return a.Cost() < b.Cost(); });
  EXPECT_EQ(best->gains, result.gains);
  EXPECT_EQ(result.leaders.back().flights, result.flights);
}

TEST(Tune, AGainOnALogScaleHasEqualFactorsAtEqualSteps) {
  const Gain gain{0.1, 10, true, {}};
  EXPECT_NEAR(ValueAt(gain, 0.5), 1, 1e-12);
  EXPECT_NEAR(ValueAt(gain, 0.75) / ValueAt(gain, 0.5), std::sqrt(10), 1e-5);
  EXPECT_EQ(ValueAt(gain, 1), 10);
  for (const bool log : {false, true})
    EXPECT_NEAR(Coordinate({0.1, 10, log, {}}, ValueAt(Gain{0.1, 10, log, {}}, 0.3)), 0.3, 1e-6);
}

TEST(Tune, ThePairedIntervalIsStudents) {
  // Differences 1, 2, 3: mean 2, deviation 1; t of 2 degrees of freedom at 97.5 % is 4.3027 (tables).
  const PairedCost d = ComparePaired({5, 7, 1}, {6, 9, 4});
  EXPECT_DOUBLE_EQ(d.difference, 2);
  EXPECT_NEAR(d.high, 2 + 4.3027 / std::sqrt(3), 1e-4);
  EXPECT_NEAR(d.low, 2 - 4.3027 / std::sqrt(3), 1e-4);
}

}  // namespace
}  // namespace kestrel::campaign
