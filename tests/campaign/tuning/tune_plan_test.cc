// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/tune_plan.h"

#include <gmock/gmock.h>

#include <fstream>
#include <set>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "flight/simulated/scenario.h"
#include "tests/support/diagnostic_texts.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class TunePlanTest : public InTemporaryFolder {
 protected:
  LoadedTune Load(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(folder_ / "f.yaml") << text;
    return LoadTune(folder_ / "f.yaml", overrides);
  }
  std::vector<std::string> Refusal(const std::string& text) const {
    try {
      Load(text);
    } catch (const InputError& e) {
      std::vector<std::string> messages = Texts(e);
      for (std::string& message : messages)
        if (message.starts_with(folder_.string())) message.erase(0, folder_.string().size() + 1);
      return messages;
    }
    return {};
  }
};

constexpr const char* kWhole = R"(scenario: follow
set: [image.rate_hz=10]
seed: 4
vary: {wind.mean_m_s: {uniform: [0, 6]}}
gains:
  pilot.servo.lambda_per_s: {low: 0.1, high: 4, log: true}
  autopilot.velocity_gain_per_s: {low: 0.1, high: 5, start: 0.2}
cost: {follow_distance_rms: {scale: 0.1, weight: 2}}
constraints: {max_tilt_deg: {max: 20}}
failure: 3
method: random_search
budget: 200
rows: 4
)";

TEST_F(TunePlanTest, AFileBecomesItsPlanAndTablesWithoutARowInCommon) {
  const LoadedTune tune = Load(kWhole);
  EXPECT_EQ(tune.plan.flights.name, "f");
  EXPECT_EQ(tune.plan.method, "random_search");
  EXPECT_EQ(tune.plan.cost.terms.at("follow_distance_rms").weight, 2);
  EXPECT_EQ(tune.plan.cost.constraints.at("max_tilt_deg").max, 20);
  EXPECT_EQ(tune.plan.cost.failure, 3);
  const flight::Scenario own = flight::LoadScenario("follow").scenario;
  EXPECT_EQ(tune.own.at("pilot.servo.lambda_per_s"), own.pilot.servo.lambda_per_s);
  EXPECT_EQ(tune.own.at("autopilot.velocity_gain_per_s"), own.autopilot.velocity_gain_per_s);
  EXPECT_EQ(tune.plan.gains.at("pilot.servo.lambda_per_s").start, own.pilot.servo.lambda_per_s);
  EXPECT_EQ(tune.plan.gains.at("autopilot.velocity_gain_per_s").start, 0.2);
  const SampleTable first = RowsOfRound(tune.plan, 0), second = RowsOfRound(tune.plan, 1);
  EXPECT_EQ(first.rows.size(), 4u);
  EXPECT_EQ(second.rows.size(), 4u);
  EXPECT_EQ(HashOf(second), HashOf(RowsOfRound(tune.plan, 1)));
  EXPECT_EQ(tune.fresh.rows.size(), 10u);
  EXPECT_EQ(tune.held_out.rows.size(), 50u);
  std::set<std::string> seeds;
  for (const SampleTable* table : {&first, &second, &tune.fresh, &tune.held_out})
    for (const auto& row : table->rows) seeds.insert(row[0]);
  EXPECT_EQ(seeds.size(), 68u);
}

// What a tuning writes takes the place of the file of gains that it found.
TEST_F(TunePlanTest, GainsOfTheScenariosFileThatAreNotTunedAreKnown) {
  std::ofstream(folder_ / "gains.yaml") << "pilot.servo.lambda_per_s: 1.5\npilot.servo.lambda_yaw_per_s: 1\n";
  const LoadedTune tune = Load(kWhole, {"set=[gains=" + (folder_ / "gains.yaml").string() + "]"});
  EXPECT_THAT(tune.others, ElementsAre("pilot.servo.lambda_yaw_per_s=1"));
  EXPECT_EQ(tune.own.at("pilot.servo.lambda_per_s"), 1.5);
}

TEST_F(TunePlanTest, AnotherSeedIsJudgedOnTheSameHeldOutRows) {
  const LoadedTune one = Load(kWhole), other = Load(kWhole, {"seed=5"});
  EXPECT_EQ(HashOf(one.held_out), HashOf(other.held_out));
  EXPECT_NE(HashOf(RowsOfRound(one.plan, 0)), HashOf(RowsOfRound(other.plan, 0)));
  EXPECT_NE(HashOf(one.fresh), HashOf(other.fresh));
}

TEST_F(TunePlanTest, EveryMistakeIsNamedWithFileLineKeyAndWhatWouldBeValid) {
  EXPECT_THAT(
      Refusal(R"(scenario: follow
set: [pilot.servo.lambda_yaw_per_s=1]
vary: {wind.mean_m_s: {uniform: [0, 6]}, image.latency_s: {uniform: [0, 6]}}
gains:
  wind.mean_m_s: {low: 0, high: 3}
  pilot.servo.lambda_yaw_per_s: {low: 0, high: 3}
  pilot.servo.lambda_per_s: {low: 0, high: 3, log: true}
  pilot.servo.speed_limit_m_s: {low: 2, high: 1, start: 7}
cost: {follow_distance_rmse: {scale: 0.1}, in_view_share: {weight: 1, worst: 0}}
constraints: {max_tilt_deg: {}, settle_s: {max: 9}, closest_m: {min: 3, max: 2}}
method: cma
)"),
      ElementsAre(
          "f.yaml:9: cost.in_view_share.scale: must be given",
          "f.yaml:9: cost.in_view_share.worst: 0 is out of range; valid: 1e-09 to 1000000000",
          StartsWith("f.yaml:11: method: 'cma' is not valid;"),
          "f.yaml:7: gains.pilot.servo.lambda_per_s: low = 0 has no logarithm; valid: above 0",
          "f.yaml:6: gains.pilot.servo.lambda_yaw_per_s: is tuned, and set has "
          "'pilot.servo.lambda_yaw_per_s=1'; "
          "valid: start",
          "f.yaml:8: gains.pilot.servo.speed_limit_m_s: low = 2 is not below high = 1",
          "f.yaml:8: gains.pilot.servo.speed_limit_m_s.start: 7 is out of its bounds; valid: 2 to 1",
          "f.yaml:5: gains.wind.mean_m_s: varies from flight to flight too; valid: one of the two",
          "f.yaml:3: vary.image.latency_s: 6 is out of range; valid: 0 to 2",
          "f.yaml:9: cost.follow_distance_rmse: there is no metric 'follow_distance_rmse'; did you mean "
          "'follow_distance_rms'?",
          StartsWith("f.yaml:10: constraints.closest_m: a flight of this scenario, of the mission 'follow', "
                     "has no 'closest_m'; valid: "),
          "f.yaml:10: constraints.closest_m: min = 3 is above max = 2, so that nothing keeps to both; valid: "
          "min no more than max",
          "f.yaml:10: constraints.max_tilt_deg: has no limit; valid: max, min or both",
          "f.yaml:10: constraints.settle_s: a flight of this scenario, of the mission 'follow', has no "
          "'settle_s'; valid: as said above"));
}

TEST_F(TunePlanTest, AGainThatTheScenarioRefusesIsRefused) {
  EXPECT_THAT(
      Refusal(R"(scenario: follow
gains:
  pilot.servo.lambda_pers: {low: 0.1, high: 3, start: 1}
  pilot.servo.lambda_per_s: {low: 0.1, high: 30}
  pilot.tracker.max_points: {low: 100, high: 300, start: 200}
  pilot.servo.lambda_yaw_per_s: {low: 2, high: 3}
cost: {follow_u_rms_px: {scale: 10}}
)"),
      ElementsAre("f.yaml:4: gains.pilot.servo.lambda_per_s: 30 is out of range; valid: 0 to 5",
                  "f.yaml:3: gains.pilot.servo.lambda_pers: unknown key; did you mean 'lambda_per_s'?",
                  StartsWith("f.yaml:6: gains.pilot.servo.lambda_yaw_per_s: the scenario has 0.8, out of "
                             "its bounds; valid: "),
                  HasSubstr("f.yaml:5: gains.pilot.tracker.max_points: 176.393")));
}

TEST_F(TunePlanTest, MistakesOfGainsAreSaidBesideThoseOfTheRest) {
  EXPECT_THAT(
      Refusal(R"(scenario: follow
vary: {wind.mean_m_s: {uniform: [0, 60]}}
gains:
  pilot.servo.lambda_pers: {low: 0.1, high: 3, start: 1}
  pilot.servo.lambda_per_s: {low: 0.1, high: 30}
  pilot.servo.lambda_yaw_per_s: {low: 3, high: .inf}
  wind.turbulence: {low: 0, high: 1}
  camera: {low: 0, high: 1}
cost: {follow_u_rms_px: {scale: 10}}
constraints: {max_tilt_deg: {max: abc}}
)"),
      ElementsAre(StartsWith("f.yaml:6: gains.pilot.servo.lambda_yaw_per_s.high: .inf is not a finite"),
                  StartsWith("f.yaml:10: constraints.max_tilt_deg.max: 'abc' is not a number"),
                  StartsWith("f.yaml:2: vary.wind.mean_m_s: 60 is out of range"),
                  StartsWith("f.yaml:8: gains.camera: with 0: there is no camera '0'"),
                  StartsWith("f.yaml:5: gains.pilot.servo.lambda_per_s: 30 is out of range"),
                  StartsWith("f.yaml:4: gains.pilot.servo.lambda_pers: unknown key"),
                  StartsWith("f.yaml:7: gains.wind.turbulence: ")));
}

TEST_F(TunePlanTest, WhatIsNotGivenIsSaidOnce) {
  EXPECT_THAT(Refusal("scenario: follow\n"),
              ElementsAre("f.yaml:1: gains: must be given", "f.yaml:1: cost: must be given"));
}

TEST_F(TunePlanTest, AnOverrideOfTheScenariosKeyStandsInSet) {
  EXPECT_THAT(Load(kWhole, {"duration_s=5", "image.rate_hz=20"}).plan.flights.set,
              ElementsAre("image.rate_hz=20", "duration_s=5"));
}

TEST_F(TunePlanTest, ABudgetInWhichNothingCanBeFoundIsRefused) {
  EXPECT_THAT(
      Refusal("scenario: follow\ngains: {pilot.servo.lambda_per_s: {low: 0.1, high: 3}}\n"
              "cost: {follow_u_rms_px: {scale: 10}}\nbudget: 60\n"),
      ElementsAre("f.yaml:4: budget: 60 flights are not enough for the start and one round of 6 candidates "
                  "on 2 rows, and 5 leaders on 10 fresh ones; valid: 64 or more"));
}

TEST(Tunings, EveryFileOfEveryFlightIsValid) {
  int files = 0;
  for (const std::string& flight : NamesIn(Root() / "scenarios", "")) {
    const auto folder = Root() / "scenarios" / flight / "tunings";
    for (const std::string& name : NamesIn(folder, ".yaml")) {
      EXPECT_NO_THROW(LoadTune(folder / (name + ".yaml"))) << name;
      ++files;
    }
  }
  EXPECT_GE(files, 4);
}

}  // namespace
}  // namespace kestrel::campaign
