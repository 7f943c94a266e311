// SPDX-License-Identifier: Apache-2.0
#include "campaign/table/campaign_plan.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "flight/simulated/scenario.h"
#include "tests/support/diagnostic_texts.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class CampaignPlanTest : public InTemporaryFolder {
 protected:
  fs::path Write(const std::string& text, const std::string& name = "f.yaml") const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  LoadedCampaign Load(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    return LoadCampaign(Write(text), overrides);
  }
  // The mistakes, without the folder.
  std::vector<std::string> Refusal(const std::string& text,
                                   const std::vector<std::string>& overrides = {}) const {
    try {
      Load(text, overrides);
    } catch (const InputError& e) {
      std::vector<std::string> messages = Texts(e);
      for (std::string& message : messages)
        for (std::size_t at; (at = message.find(folder_.string() + '/')) != std::string::npos;)
          message.erase(at, folder_.string().size() + 1);
      return messages;
    }
    return {};
  }
};

constexpr const char* kWhole = R"(name: windy
scenario: landing
set: [image.rate_hz=20, "start.offset_m=[0.1, 0]"]
runs: 2
seed: 7
sampling: independent
vary:
  wind.mean_m_s: {uniform: [0, 6]}
  wind: {from_deg: {truncated_normal: [180, 40, 0, 360]}}
  image.latency_s: {log_uniform: [0.02, 0.12]}
  pilot.servo.lambda_per_s: {normal: [1, 0.05]}
  occlusion: {choice: [{share: 0.5, until_s: 3}, {share: 0}]}
  pad.position_m.0: {uniform: [-2, 2]}
  image.bits: {grid: [7, 8]}
correlated: [{keys: [wind.mean_m_s, wind.from_deg], rank_correlation: -0.5}]
same: [{key: pad.position_m.1, as: pad.position_m.0}]
metrics: [touchdown_error_m]
limit_s: 60
thresholds: {success: {min: 0.98}, touchdown_error_m: {quantile: 0.95, max: 0.15}}
)";

TEST_F(CampaignPlanTest, AFileBecomesItsPlanAndATableThatTheScenarioTakes) {
  const LoadedCampaign loaded = Load(kWhole);
  const CampaignPlan& plan = loaded.plan;
  EXPECT_EQ(plan.name, "windy");
  EXPECT_EQ(plan.scenario, "landing");
  EXPECT_THAT(plan.set, ElementsAre("image.rate_hz=20", "start.offset_m=[0.1, 0]"));
  EXPECT_EQ(plan.seed, 7u);
  EXPECT_EQ(plan.limit_s, 60);
  EXPECT_EQ(std::get<TruncatedNormal>(plan.vary.at("wind.from_deg")).mean, 180);
  EXPECT_EQ(plan.correlated.at(0).rank_correlation, -0.5);
  EXPECT_EQ(plan.thresholds.at("touchdown_error_m").quantile, 0.95);
  EXPECT_EQ(loaded.text, kWhole);
  EXPECT_THAT(loaded.table.keys,
              ElementsAre("seed", "image.bits", "image.latency_s", "occlusion", "pad.position_m.0",
                          "pilot.servo.lambda_per_s", "wind.from_deg", "wind.mean_m_s", "pad.position_m.1"));
  ASSERT_EQ(loaded.table.rows.size(), 4u);
  for (std::size_t row = 0; row < 4; ++row) {
    const auto& values = loaded.table.rows[row];
    const flight::LoadedScenario flown = flight::LoadScenario(plan.scenario, OverridesOf(loaded.table, row));
    EXPECT_EQ(std::to_string(flown.scenario.seed), values[0]);
    EXPECT_EQ(flown.simulator.wind.mean_m_s, std::stod(values[7]));
    EXPECT_EQ(flown.simulator.scene.pad_position_m.x(), std::stod(values[4]));
    EXPECT_EQ(flown.simulator.scene.pad_position_m.y(), std::stod(values[4]));
    EXPECT_EQ(std::to_string(flown.scenario.image.bits), values[1]);
    EXPECT_EQ(flown.scenario.occlusion.share, values[3] == "{share: 0.5, until_s: 3}" ? 0.5 : 0);
  }
}

TEST_F(CampaignPlanTest, AFileNeedsNothingButItsScenario) {
  const LoadedCampaign loaded = Load("scenario: follow\n");
  EXPECT_EQ(loaded.plan.name, "f");
  EXPECT_EQ(loaded.plan.sampling, "latin_hypercube");
  EXPECT_THAT(loaded.table.keys, ElementsAre("seed"));
  EXPECT_EQ(loaded.table.rows.size(), 100u);
}

TEST_F(CampaignPlanTest, MetricsMayHaveTheirFormerNames) {
  const CampaignPlan plan =
      Load("scenario: follow\nmetrics: [greatest_tilt_deg]\nthresholds: {greatest_tilt_deg: {max: 30}}\n")
          .plan;
  EXPECT_THAT(plan.metrics, ElementsAre("max_tilt_deg"));
  EXPECT_EQ(*plan.thresholds.at("max_tilt_deg").max, 30);
}

TEST_F(CampaignPlanTest, OverridesReachTheFileAndItsDistributions) {
  const LoadedCampaign loaded =
      Load("scenario: follow\nvary: {wind.mean_m_s: {uniform: [0, 6]}}\n",
           {"runs=4", "vary.wind.mean_m_s={uniform: [1, 2]}", "vary.image.noise_grey={grid: [1, 2]}"});
  EXPECT_EQ(loaded.table.rows.size(), 8u);
  EXPECT_EQ(std::get<Uniform>(loaded.plan.vary.at("wind.mean_m_s")).low, 1);
  // Otherwise two campaigns would have the same text and other tables.
  EXPECT_THAT(loaded.text, HasSubstr("--set vary.wind.mean_m_s={uniform: [1, 2]}"));
}

TEST_F(CampaignPlanTest, AnOverrideThatSaysWhatTheFileSaysMakesNoOtherPlan) {
  const std::string file = "scenario: follow\nruns: 4\nset: [duration_s=9]\n";
  EXPECT_EQ(Load(file, {"runs=4", "seed=1", "sampling=latin_hypercube", "duration_s=9"}).text, file);
  EXPECT_EQ(Load(file, {"runs=5", "runs=4"}).text, file);
  EXPECT_EQ(Load(file, {"runs=4", "seed=2"}).text, file + "\n# --set seed=2\n");
}

TEST_F(CampaignPlanTest, AnOverrideOfTheScenariosKeyStandsInSet) {
  const std::string file = "scenario: follow\nset: [duration_s=9, wind.mean_m_s=1, wind.from_deg=3]\n";
  const LoadedCampaign loaded = Load(file, {"duration_s=1", "wind={mean_m_s: 2}", "image.rate_hz=10"});
  EXPECT_THAT(loaded.plan.set, ElementsAre("duration_s=1", "wind={mean_m_s: 2}", "image.rate_hz=10"));
  EXPECT_THAT(loaded.text, EndsWith("\n# --set duration_s=1\n\n# --set wind={mean_m_s: 2}\n\n# --set "
                                    "image.rate_hz=10\n"));
  // A key of both is the campaign's.
  EXPECT_EQ(Load(file, {"seed=5"}).plan.seed, 5u);
  EXPECT_THAT(Refusal(file, {"duration_s=-1"}),
              ElementsAre("--set duration_s=-1: duration_s: -1 is out of range; valid: 0.1 to 36000"));
  EXPECT_THAT(Refusal(file, {"durashun_s=1", "seeds=2"}),
              ElementsAre("--set seeds=2: seeds: unknown key; did you mean 'seed'?",
                          "--set durashun_s=1: durashun_s: unknown key; did you mean 'duration_s'?"));
  EXPECT_THAT(Refusal(file, {"speed_of_light=1"}),
              ElementsAre(AllOf(StartsWith("--set speed_of_light=1: speed_of_light: unknown key; valid: "),
                                HasSubstr("duration_s"))));
}

TEST_F(CampaignPlanTest, WhatFollowsFromAMistakeIsNotSaidBesideIt) {
  EXPECT_THAT(Refusal("scenario: follow\nvary:\n  image.noise_grey: {uniform: [6, 0]}\n"
                      "  wind.mean_m_s: {uniform: [0, 6]}\n"
                      "correlated: [{keys: [wind.mean_m_s, image.noise_grey], rank_correlation: 0.5}]\n"
                      "same: [{key: start.height_m, as: image.noise_grey}]\n"
                      "thresholds: {follow_distance_rms: {max: abc}}\n"),
              ElementsAre("f.yaml:7: thresholds.follow_distance_rms.max: 'abc' is not a number; valid: "
                          "-1000000000 to 1000000000",
                          "f.yaml:3: vary.image.noise_grey: low = 6 is not below high = 0"));
}

TEST_F(CampaignPlanTest, AScenarioMayLieBesideTheFile) {
  Write("mission: pose\nwind: {mean_m_s: 1}\n", "own.yaml");
  const LoadedCampaign loaded = Load("scenario: own.yaml\nruns: 1\n");
  EXPECT_EQ(loaded.plan.scenario, (folder_ / "own.yaml").string());
  EXPECT_EQ(flight::LoadScenario(loaded.plan.scenario).simulator.wind.mean_m_s, 1);
}

TEST_F(CampaignPlanTest, EveryMistakeIsNamedWithFileLineKeyAndWhatWouldBeValid) {
  const auto mistakes = Refusal(R"(scenario: landing
sampling: sobel
runs: 0
vary:
  wind.meen_m_s: {uniform: [0, 6]}
  wind.mean_m_s: {uniform: [6, 0]}
  image.noise_grey: {normal: [4, 2]}
  image.latency_s: {log_uniform: [0, 1]}
  image.jpeg_quality: {uniform: [50, 90]}
  start.height_m: {unifrom: [4, 5]}
  start.yaw_deg: {truncated_normal: [0, -1, -5, 5]}
  wind.from_deg: {uniform: [0, 400]}
  world: {choice: [airfield, winter_cloudly]}
  vehicle: {grid: []}
  pad.yaw_deg: {uniform: 3}
  pad.size: 4
metrics: [touch_down_error_m]
thresholds: {succes: {min: 1}, success: {min: 98}, touchdown_s: {quantile: 1, max: 3}, rest_error_m: {}}
speed: 3
)");
  EXPECT_THAT(
      mistakes,
      ElementsAre(
          "f.yaml:3: runs: 0 is out of range; valid: 1 to 10000000",
          "f.yaml:2: sampling: 'sobel' is not valid; did you mean 'sobol'? valid: independent, "
          "latin_hypercube, sobol",
          "f.yaml:19: speed: unknown key; did you mean 'seed'?",
          "f.yaml:6: vary.wind.mean_m_s: low = 6 is not below high = 0",
          "f.yaml:8: vary.image.latency_s: low = 0 has no logarithm; valid: above 0",
          "f.yaml:10: vary.start.height_m: there is no distribution 'unifrom'; did you mean 'uniform'? "
          "valid: "
          "uniform, log_uniform, normal, truncated_normal, choice, grid",
          "f.yaml:11: vary.start.yaw_deg: the standard deviation is -1; valid: above 0",
          "f.yaml:14: vary.vehicle: the grid is empty; valid: a list of one value or more",
          "f.yaml:15: vary.pad.yaw_deg: uniform: 3 is not valid; valid: [low, high]",
          "f.yaml:16: vary.pad.size: 4 is not a distribution; valid: one of uniform, log_uniform, normal, "
          "truncated_normal, choice, grid, as in {uniform: [0, 6]}",
          "f.yaml:9: vary.image.jpeg_quality: 65.278640452 is not a whole number; valid: 0 to 100; of whole "
          "numbers valid: choice or grid",
          "f.yaml:7: vary.image.noise_grey: -16 is out of range; valid: 0 to 60; a normal reaches 10 "
          "deviations off: valid: truncated_normal",
          "f.yaml:12: vary.wind.from_deg: 400 is out of range; valid: 0 to 360",
          "f.yaml:5: vary.wind.meen_m_s: unknown key; did you mean 'mean_m_s'?",
          HasSubstr("f.yaml:13: vary.world: with winter_cloudly: "),
          "f.yaml:17: metrics.0: there is no metric 'touch_down_error_m'; did you mean 'touchdown_error_m'?",
          HasSubstr("f.yaml:18: thresholds.rest_error_m: has no limit; valid: max, min or both"),
          "f.yaml:18: thresholds.succes: there is no metric 'succes'; did you mean 'success'?",
          "f.yaml:18: thresholds.success: 98 is not a share of the runs; valid: 0 to 1",
          "f.yaml:18: thresholds.touchdown_s.quantile: 1 is out of range; valid: between 0 and 1"));
}

TEST_F(CampaignPlanTest, GroupsThatCannotBeCorrelatedAreRefused) {
  EXPECT_THAT(
      Refusal(R"(scenario: landing
vary:
  wind.mean_m_s: {uniform: [0, 6]}
  wind.from_deg: {uniform: [0, 360]}
  image.noise_grey: {uniform: [0, 6]}
  image.rate_hz: {choice: [10, 20]}
  image.bits: {grid: [7, 8]}
correlated:
  - {keys: [wind.mean_m_s, wind.from_deg, image.noise_grey], rank_correlation: -0.6}
  - {keys: [wind.mean_m_s, image.rate_hz, image.bits, wind.form_deg], rank_correlation: 0.5}
  - {keys: [start.height_m], rank_correlation: 1}
same: [{key: start.height_m, as: wind.mean}, {key: image.rate_hz, as: wind.mean_m_s}, {key: seed, as: image.bits}]
)"),
      ElementsAre(
          "f.yaml:9: correlated.0.rank_correlation: -0.6 each with each is no correlation that 3 keys can "
          "have; valid: above -0.4826 and below 1",
          "f.yaml:10: correlated.1.keys: 'wind.mean_m_s' is in correlated.0 already; valid: in one group",
          "f.yaml:10: correlated.1.keys: 'image.rate_hz' is a choice, which has no ranks; valid: uniform, "
          "log_uniform, normal, truncated_normal",
          "f.yaml:10: correlated.1.keys: 'image.bits' is a grid, which has no ranks; valid: uniform, "
          "log_uniform, normal, truncated_normal",
          "f.yaml:10: correlated.1.keys: 'wind.form_deg' does not vary; did you mean 'wind.from_deg'?",
          "f.yaml:11: correlated.2.keys: a group of 1; valid: two keys or more",
          StartsWith("f.yaml:11: correlated.2.keys: 'start.height_m' does not vary; valid: image.bits, "),
          HasSubstr("f.yaml:11: correlated.2.rank_correlation: 1 each with each"),
          StartsWith("f.yaml:12: same.0.as: 'wind.mean' does not vary; "),
          "f.yaml:12: same.1.key: 'image.rate_hz' varies for itself; valid: one of the two",
          "f.yaml:12: same.2.key: each run has a seed of its own; valid: another key, or vary.seed",
          "f.yaml:12: same.1.key: 0 is out of range; valid: 0.5 to 500"));
}

TEST_F(CampaignPlanTest, AKeyIsSetOrVaries) {
  EXPECT_THAT(
      Refusal("scenario: follow\nset: [start.height_m=3, wind.mean_m_s=3]\n"
              "vary:\n  wind.mean_m_s: {uniform: [0, 6]}\n  start: {choice: [{height_m: 4}]}\n"),
      ElementsAre("f.yaml:5: vary.start: 'start' varies, and set has 'start.height_m=3'; valid: one of "
                  "the two",
                  "f.yaml:4: vary.wind.mean_m_s: 'wind.mean_m_s' varies, and set has "
                  "'wind.mean_m_s=3'; valid: one of the two"));
}

TEST_F(CampaignPlanTest, WhatIsGivenTwiceOrCannotBeKeptIsRefused) {
  EXPECT_THAT(
      Refusal("scenario: hover\nset: [duration_s=0.5, seed=3, duration_s=0.6]\n"
              "vary:\n  wind: {choice: [{mean_m_s: 3}]}\n  wind.mean_m_s: {uniform: [0, 6]}\n"
              "metrics: [settle_s, fix_share, settle_s]\nthresholds: {settle_s: {min: 3, max: 1}}\n"),
      ElementsAre(
          "f.yaml:2: set.2: 'duration_s=0.6': 'duration_s' is given twice, first as 'duration_s=0.5'; valid: "
          "once",
          "f.yaml:5: vary.wind.mean_m_s: is a part of 'wind', which varies too; valid: one of the two",
          "f.yaml:6: metrics.2: 'settle_s' is given twice; valid: once",
          "f.yaml:7: thresholds.settle_s: min = 3 is above max = 1, so that nothing keeps to both; valid: "
          "min "
          "no more than max"));
  EXPECT_THAT(Refusal("scenario: hover\nset: [\"wind={mean_m_s: 3}\", wind.from_deg=90]\n"
                      "thresholds: {settle_s: {min: 1, max: 1}}\n"),
              ElementsAre());
}

TEST_F(CampaignPlanTest, AMetricThatTheFlightCannotHaveIsRefusedBeforeItFlies) {
  EXPECT_THAT(
      Refusal("scenario: hover\nmetrics: [touchdown_error_m, closest_m, setle_s]\n"
              "thresholds: {in_view_share: {min: 0.5}}\n"),
      ElementsAre(
          "f.yaml:2: metrics.0: a flight of this scenario, of the mission 'hover', has no "
          "'touchdown_error_m'; valid: fix_x_rmse_m, fix_y_rmse_m, fix_z_rmse_m, fix_yaw_rmse_deg, "
          "fix_share, "
          "longest_loss_s, settle_s, hold_horizontal_rmse_m, hold_vertical_rmse_m, hold_yaw_rmse_deg, "
          "max_tilt_deg",
          "f.yaml:2: metrics.1: a flight of this scenario, of the mission 'hover', has no 'closest_m'; "
          "valid: "
          "as said above",
          "f.yaml:2: metrics.2: there is no metric 'setle_s'; did you mean 'settle_s'?",
          "f.yaml:3: thresholds.in_view_share: a flight of this scenario, of the mission 'hover', has no "
          "'in_view_share'; valid: as said above"));
  // What may vary may be there.
  EXPECT_THAT(Refusal("scenario: hover\nmetrics: [failure_noticed_s]\nvary:\n  sensors.attitude_faults: "
                      "{choice: [[], [{type: freeze, from_s: 1, until_s: 3}]]}\n"),
              ElementsAre());
}

TEST_F(CampaignPlanTest, AScenarioThatIsNoneOrNotValidIsRefused) {
  EXPECT_THAT(
      Refusal("scenario: landin\n"),
      ElementsAre("f.yaml:1: scenario: there is no scenario 'landin', nor a file 'landin'; did you mean "
                  "'landing'?"));
  EXPECT_THAT(Refusal("runs: 3\n"), ElementsAre("f.yaml:1: scenario: must be given"));
  EXPECT_THAT(
      Refusal("scenario: follow\nset: [wind.mean_m_s=-1]\n"),
      ElementsAre("f.yaml:2: set: wind.mean_m_s=-1: wind.mean_m_s: -1 is out of range; valid: 0 to 20"));
  EXPECT_THAT(Refusal("scenario: follow\nname: a/b\n"),
              ElementsAre("f.yaml:2: name: 'a/b' cannot name a folder; valid: no slash, no leading dot, "
                          "no control character"));
}

TEST_F(CampaignPlanTest, WhatTheScenarioRefusesForAnotherReasonThanItsRangeIsSaid) {
  // More of the aircraft than its autopilot gives.
  const auto mistakes =
      Refusal("scenario: follow\nvary: {flight.gains.speed_limit_m_s: {uniform: [1, 9]}}\n");
  EXPECT_THAT(mistakes, ElementsAre("f.yaml:2: vary.flight.gains.speed_limit_m_s: 9, and "
                                    "autopilot.speed_limit_m_s is 3; valid: no more than that"));
}

TEST_F(CampaignPlanTest, AKeyMayHaveItsMeaningFromAChoice) {
  EXPECT_THAT(Refusal("scenario: landing\nvary:\n  landscape.light: {uniform: [0.5, 1]}\n"
                      "  world: {choice: [winter_cloudy, autumn_clear]}\n"),
              ElementsAre());
  EXPECT_THAT(Refusal("scenario: landing\nvary: {landscape.light: {uniform: [0.5, 1]}}\n"),
              Contains(HasSubstr("the world 'airfield' is not made from numbers")));
}

TEST_F(CampaignPlanTest, BytesOfAWrongFileAreNoCommandsToTheTerminal) {
  EXPECT_STREQ(InputError({}, "\x1b[31mred \xc2\x9b \xff gr\xc3\xbcn\x7f \xe2\x82").what(),
               "\\x1b[31mred \\xc2\\x9b \\xff gr\xc3\xbcn\\x7f \\xe2\\x82");
  EXPECT_THAT(Refusal("scenario: follow\nruns: " + std::string(5000, 'x') + "\n"),
              ElementsAre("f.yaml:2: runs: '" + std::string(100, 'x') +
                          "'... is not a number; valid: 1 to 10000000"));
}

TEST_F(CampaignPlanTest, ATableTooLongIsRefusedBeforeItIsDrawn) {
  EXPECT_THAT(Refusal("scenario: follow\nruns: 5000000\nvary: {image.rate_hz: {grid: [10, 20, 30]}}\n"),
              ElementsAre(HasSubstr("15000000 runs; valid: no more than 10000000")));
}

std::string Numbers(int count) {
  std::string all = "[0";
  for (int i = 1; i < count; ++i) all += fmt::format(", {}", i);
  return all + "]";
}

TEST_F(CampaignPlanTest, GridsOfManyPointsAreRefusedWithoutTryingEach) {
  std::string file = "scenario: follow\nruns: 3\nvary:\n";
  for (int axis = 0; axis < 6; ++axis) file += fmt::format("  wind.k{}: {{grid: {}}}\n", axis, Numbers(1000));
  EXPECT_THAT(Refusal(file),
              ElementsAre("f.yaml:2: runs: 3 at each of the 1000000000000000000 points of the grids are "
                          "3000000000000000000 runs; valid: no more than 10000000"));
}

TEST_F(CampaignPlanTest, ALongGridOfNumbersIsTriedAtItsEnds) {
  // To load the scenario with each of them would take minutes.
  const std::string grid = Numbers(20000);
  EXPECT_THAT(Refusal("scenario: follow\nruns: 1\nvary: {camera_seed: {grid: " + grid + "}}\n"),
              ElementsAre(HasSubstr("vary.camera_seed: unknown key")));
  EXPECT_THAT(Refusal("scenario: follow\nruns: 1\nvary: {image.rate_hz: {grid: " + grid + "}}\n"),
              ElementsAre("f.yaml:3: vary.image.rate_hz: 0 is out of range; valid: 0.5 to 500",
                          "f.yaml:3: vary.image.rate_hz: 19999 is out of range; valid: 0.5 to 500"));
  EXPECT_THAT(Refusal("scenario: follow\nruns: 1\nvary: {image.jpeg_quality: {choice: [0.5, " +
                      Numbers(101).substr(1) + "}}\n"),
              ElementsAre("f.yaml:3: vary.image.jpeg_quality: 0.5 is not a whole number; valid: 0 to 100"));
}

TEST(Campaigns, EveryFileOfEveryFlightIsValidAndNoScenario) {
  const std::vector<std::string> scenarios = ScenarioNames();
  int files = 0;
  for (const std::string& flight : NamesIn(Root() / "scenarios", "")) {
    for (const std::string& name : NamesIn(Root() / "scenarios" / flight / "campaigns", ".yaml")) {
      const LoadedCampaign loaded =
          LoadCampaign(Root() / "scenarios" / flight / "campaigns" / (name + ".yaml"));
      EXPECT_EQ(loaded.plan.name, name);
      EXPECT_THAT(loaded.plan.metrics, ::testing::Not(::testing::IsEmpty())) << name;
      EXPECT_THAT(scenarios, ::testing::Not(Contains(name)));
      // Rows that the scenario refuses would be flights lost.
      for (const std::size_t row : {std::size_t{0}, loaded.table.rows.size() - 1})
        EXPECT_NO_THROW(flight::LoadScenario(loaded.plan.scenario, OverridesOf(loaded.table, row))) << name;
      ++files;
    }
  }
  EXPECT_GE(files, 6);
}

}  // namespace
}  // namespace kestrel::campaign
