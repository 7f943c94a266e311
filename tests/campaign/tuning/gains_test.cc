// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>

#include "base/yaml/yaml_fields.h"
#include "campaign/tuning/tune_files.h"
#include "flight/simulated/scenario.h"
#include "tests/support/diagnostic_texts.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class GainsTest : public InTemporaryFolder {
 protected:
  std::string Write(const std::string& text, const std::string& name) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::vector<std::string> Refusal(const std::string& scenario) const {
    try {
      flight::LoadScenario(scenario);
    } catch (const InputError& e) {
      return Texts(e);
    }
    return {};
  }
};

TEST_F(GainsTest, WhatATuningWritesAScenarioTakes) {
  LoadedTune tune;
  tune.plan.flights.scenario = "hover";
  tune.others = {"pilot.estimator.acceleration_m_s2=0.7"};
  tune.plan.gains = {{"pilot.servo.lambda_per_s", {0.1, 3, true, 0.2}},
                     {"autopilot.velocity_gain_per_s", {0.1, 3, true, 0.3}}};
  TuneResult result;
  result.gains = {{"pilot.servo.lambda_per_s", 1.23456}, {"autopilot.velocity_gain_per_s", 0.7}};
  result.start = {0, {}, 0, {3, 4}, {true, false}, {}};
  result.tuned = {0, {}, 0, {1, 2}, {true, true}, {}};
  result.from_start = {-2, -2.5, -1.5};
  const std::string text = GainsFile(tune, result, "kestrel tune poor.yaml", "0.1.0 abc");
  EXPECT_THAT(text, HasSubstr("kestrel tune poor.yaml"));
  EXPECT_THAT(text, HasSubstr("0.1.0 abc"));
  EXPECT_THAT(text, HasSubstr("1.5, 2 of 2 passed; of those it began with 3.5, 1 of 2 passed"));
  EXPECT_THAT(text, HasSubstr("-2 [-2.5, -1.5], better than those"));
  const std::string gains = Write(text, "gains.yaml");
  // Over what the scenario says itself, and under what is set for the run.
  const std::string scenario =
      Write("mission: hover\ngains: gains.yaml\npilot: {servo: {lambda_per_s: 9}}\n", "s.yaml");
  const flight::Scenario s = flight::LoadScenario(scenario).scenario;
  EXPECT_EQ(s.pilot.servo.lambda_per_s, 1.23456);
  EXPECT_EQ(s.autopilot.velocity_gain_per_s, 0.7);
  EXPECT_EQ(s.pilot.estimator.acceleration_m_s2, 0.7);
  EXPECT_EQ(flight::LoadScenario(scenario, {"pilot.servo.lambda_per_s=2"}).scenario.pilot.servo.lambda_per_s,
            2);
  EXPECT_EQ(flight::LoadScenario("follow", {"gains=" + gains}).scenario.pilot.servo.lambda_per_s, 1.23456);
  // The resolved text has the values, and needs the file no more.
  EXPECT_EQ(flight::LoadScenario(Write(ToYaml(s), "resolved.yaml")).scenario.autopilot.velocity_gain_per_s,
            0.7);
  EXPECT_THAT(ToYaml(s), ::testing::Not(HasSubstr("gains.yaml")));
}

TEST_F(GainsTest, MistakesInAGainsFileNameItAndItsLine) {
  const std::string scenario = Write("mission: hover\ngains: gains.yaml\n", "s.yaml");
  EXPECT_THAT(Refusal(scenario),
              ElementsAre(scenario + ":2: gains: there is no file 'gains.yaml'; valid: one "
                                     "beside the scenario or from here"));
  const std::string gains = Write("# tuned\npilot.servo.lambda_pers: 1\nwind.mean_m_s: 99\n", "gains.yaml");
  EXPECT_THAT(Refusal(scenario),
              ElementsAre(gains + ":2: pilot.servo.lambda_pers: unknown key; did you mean 'lambda_per_s'?",
                          gains + ":3: wind.mean_m_s: 99 is out of range; valid: 0 to 20"));
  Write("pilot: {servo: {lambda_per_s: 1}}\n", "gains.yaml");
  EXPECT_THAT(Refusal(scenario),
              ElementsAre(gains + ":1: pilot: is not a single value; valid: lines of key.path: value"));
}

TEST_F(GainsTest, AGainGivenTwiceAndAFileWithinTheFileAreRefused) {
  const std::string scenario = Write("mission: hover\ngains: gains.yaml\n", "s.yaml");
  const std::string gains =
      Write("pilot.servo.lambda_per_s: 1\ngains: other.yaml\npilot.servo.lambda_per_s: 2\n", "gains.yaml");
  EXPECT_THAT(
      Refusal(scenario),
      ElementsAre(gains + ":2: gains: a file of gains names no other; valid: lines of key.path: value",
                  gains + ":3: pilot.servo.lambda_per_s: given twice, first at " + gains + ":1"));
}

}  // namespace
}  // namespace kestrel::campaign
