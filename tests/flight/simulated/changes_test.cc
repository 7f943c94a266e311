// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/changes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "base/file/files.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/runner.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

LoadedScenario Short(const std::string& scenario, std::vector<std::string> more) {
  more.insert(more.end(), {"duration_s=1.6", "start.settle_s=1", "seed=101"});
  return LoadScenario(scenario, more);
}

std::string Declares(const std::string& key) { return "changeable=[{key: " + key + "}]"; }

// One key of each kind that can be changed, and what it is changed to.
struct Case {
  const char *name, *scenario, *key, *value;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class ChangesOfAKind : public InTemporaryFolder, public ::testing::WithParamInterface<Case> {};

TEST_P(ChangesOfAKind, MadeByHandAreFlownAgainFromTheFileBitForBit) {
  const Case& c = GetParam();
  const LoadedScenario loaded = Short(c.scenario, {Declares(c.key)});
  RunOptions options;
  options.folder = folder_ / "by_hand";
  options.video = false;
  int frame = 0;
  options.change = [&](Changes& changes) {
    if (++frame != 12) return;
    EXPECT_EQ(changes.Make(c.key, c.value), "");
  };
  const records::Summary by_hand = RunFlight(loaded, options).summary;
  EXPECT_EQ(by_hand.error, "");
  EXPECT_GT(frame, 12);
  const std::string events = Content(folder_ / "by_hand/events.log");
  EXPECT_THAT(events, HasSubstr(std::string("change: ") + c.key + ' '));

  const LoadedScenario file = LoadScenario(folder_ / "by_hand/scenario.yaml");
  ASSERT_EQ(file.scenario.changes.size(), 1u);
  options.folder = folder_ / "again";
  options.change = nullptr;
  const records::Summary again = RunFlight(file, options).summary, without = RunFlight(loaded, {}).summary;
  EXPECT_EQ(again.state_hash, by_hand.state_hash);
  EXPECT_EQ(again.image_hash, by_hand.image_hash);
  EXPECT_EQ(Content(folder_ / "again/events.log"), events);
  EXPECT_EQ(Content(folder_ / "again/scenario.yaml"), Content(folder_ / "by_hand/scenario.yaml"));
  EXPECT_TRUE(without.state_hash != by_hand.state_hash || without.image_hash != by_hand.image_hash);
}

INSTANTIATE_TEST_SUITE_P(
    Keys, ChangesOfAKind,
    ::testing::Values(Case{"Wind", "landing", "wind.mean_m_s", "6"},
                      Case{"WindDirection", "landing", "wind.from_deg", "90"},
                      Case{"Gusts", "landing", "wind.gusts.rate_per_min", "60"},
                      Case{"Gain", "landing", "pilot.servo.lambda_per_s", "0.3"},
                      Case{"FlightKey", "hover", "flight.yaw_deg", "40"},
                      Case{"SensorFault", "landing", "sensors.faults", "[{component: gyro, type: wrong}]"},
                      Case{"AttitudeFault", "landing", "sensors.attitude_faults", "[{type: drift}]"},
                      Case{"ActuatorFault", "landing", "actuators.faults",
                           "[{component: motor, instance: 2, type: wrong, loss: 0.2}]"},
                      Case{"FrozenCamera", "landing", "image.faults", "[{type: stuck}]"},
                      Case{"SlowCamera", "landing", "image.faults", "[{type: slow, rate_hz: 5}]"},
                      Case{"Light", "landing", "render.daylight", "0.5"},
                      Case{"TargetsPath", "avoid", "targets.0.velocity_m_s", "[-3, 2, 1]"}),
    [](const auto& of) { return std::string(of.param.name); });

class ChangesTest : public InTemporaryFolder {};

TEST_F(ChangesTest, ThatAreRefusedSayWhyAndChangeNothing) {
  const LoadedScenario loaded =
      Short("follow", {"changeable=[{key: wind.mean_m_s, max: 8}, {key: targets.0.velocity_m_s}, "
                       "{key: flight.gains.lambda_per_s}, {key: sensors.faults, choices: "
                       "['[]', '[{component: gps, type: off}]']}]",
                       "changes=[{at_s: 1.2, key: wind.mean_m_s, value: 4}]"});
  RunOptions options;
  std::vector<std::string> why;
  bool asked = false;
  options.change = [&](Changes& changes) {
    if (std::exchange(asked, true)) return;
    for (const auto& [key, value] : std::vector<std::pair<std::string, std::string>>{
             {"seed", "3"},
             {"wind.mean_m_s", "9"},
             {"wind.mean_m_s", "-1"},
             {"wind.mean_m_s", "30"},
             {"wind.mean_m_s", "much"},
             {"wind.mean_m_s", "[1"},
             {"targets.0.velocity_m_s", "[1, 0, 0]"},
             {"flight.gains.lambda_per_s", "[1, 2]"},
             {"sensors.faults", "[{component: gyro, type: off}]"}})
      why.push_back(changes.Make(key, value));
  };
  const records::Summary asked_for = RunFlight(loaded, options).summary;
  EXPECT_THAT(
      why,
      ElementsAre(
          "seed: is not among what this scenario lets change in flight; valid: wind.mean_m_s, "
          "targets.0.velocity_m_s, flight.gains.lambda_per_s, sensors.faults",
          "wind.mean_m_s: 9 is out of the range that changeable gives it; valid: 0 to 8",
          "wind.mean_m_s: -1 is out of range; valid: 0 to 8",
          "wind.mean_m_s: 30 is out of range; valid: 0 to 8",
          "wind.mean_m_s: 'much' is not a number; valid: 0 to 8", StartsWith("wind.mean_m_s: not valid YAML"),
          "targets[0]: moves in several ways; valid: one of velocity_m_s, string_m and roam_m_s",
          "flight.gains.lambda_per_s: a list of 2 is not valid; valid: a list of 3 numbers, each 0.05 "
          "to 5",
          StartsWith("sensors.faults: [{\"component\": \"gyro\", \"type\": \"off\"}] is not offered by "
                     "changeable; valid: [], or [{\"component\": \"gps\"")));
  const records::Summary flown = RunFlight(loaded, {}).summary;
  EXPECT_EQ(asked_for.state_hash, flown.state_hash);
  EXPECT_EQ(asked_for.image_hash, flown.image_hash);
}

// As a page of JSON says it.
TEST_F(ChangesTest, AChoiceIsTheSameInAnyOrderOfItsKeys) {
  const LoadedScenario loaded = Short(
      "hover", {"changeable=[{key: sensors.faults, choices: ['[]', '[{component: gps, type: off}]']}]"});
  RunOptions options;
  std::optional<std::string> why;
  options.change = [&](Changes& changes) {
    if (!why) why = changes.Make("sensors.faults", R"([{"type": "off", "component": "gps"}])");
  };
  RunFlight(loaded, options);
  EXPECT_EQ(why, "");
}

TEST_F(ChangesTest, TellWhatMayBeChangedWithItsMeaningValueAndRange) {
  const LoadedScenario loaded =
      Short("landing",
            {"changeable=[{key: wind.mean_m_s, max: 8}, {key: wind.turbulence}, {key: actuators.faults}, "
             "{key: pilot.servo.lambda_per_s}]"});
  sim::SimulatorParameters parameters = loaded.simulator;
  parameters.images = false;
  sim::Simulator simulator(parameters);
  std::vector<MadeChange> made;
  Changes changes(loaded, simulator, nullptr, [&](const MadeChange& change) { made.push_back(change); });
  EXPECT_EQ(changes.Make("pilot.servo.lambda_per_s", "1"),
            "pilot.servo.lambda_per_s: nobody flies by the scenario's own mission here");
  EXPECT_EQ(changes.Make("wind.mean_m_s", "5.5"), "");
  const std::vector<records::ChangeableKey> all = changes.All();
  ASSERT_EQ(all.size(), 3u);  // nobody flies by the mission
  EXPECT_EQ(all[0].key, "wind.mean_m_s");
  EXPECT_EQ(all[0].meaning, "mean speed of the wind, the same at every height; it scales the turbulence");
  EXPECT_EQ(all[0].value, "5.5");
  EXPECT_EQ(all[0].min, 0);
  EXPECT_EQ(all[0].max, 8);
  EXPECT_EQ(all[1].value, "true");
  EXPECT_THAT(all[1].choices, ElementsAre("true", "false"));
  EXPECT_EQ(all[2].value, "[]");
  EXPECT_EQ(all[2].min, std::nullopt);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].before, "3");
  EXPECT_EQ(made[0].value, "5.5");
  EXPECT_TRUE(made[0].by_hand);
}

TEST_F(ChangesTest, OfAScenarioComeInTheOrderOfTimeAndThoseByHandAmongThem) {
  const LoadedScenario loaded = Short("landing", {Declares("wind.mean_m_s"),
                                                  "changes=[{at_s: 1.2, key: wind.mean_m_s, value: 1}, "
                                                  "{at_s: 0.3, key: wind.mean_m_s, value: 7}]"});
  RunOptions options;
  options.folder = folder_ / "run";
  options.video = false;
  int frame = 0;
  options.change = [&](Changes& changes) {
    if (++frame != 12) return;
    EXPECT_EQ(changes.Make("wind.mean_m_s", "5"), "");
  };
  RunFlight(loaded, options);
  const std::string events = Content(folder_ / "run/events.log");
  const std::size_t first = events.find("3 -> 7"), by_hand = events.find("7 -> 5"),
                    last = events.find("5 -> 1");
  EXPECT_LT(first, by_hand);
  EXPECT_LT(by_hand, last);
  EXPECT_NE(last, std::string::npos);
  const Scenario flown = LoadScenario(folder_ / "run/scenario.yaml").scenario;
  ASSERT_EQ(flown.changes.size(), 3u);
  EXPECT_EQ(flown.changes[0].at_s, 0.3);
  EXPECT_EQ(flown.changes[1].value.text, "5");
  EXPECT_EQ(flown.changes[2].at_s, 1.2);
  EXPECT_EQ(flown.wind.mean_m_s, 3);  // as it began
}

TEST_F(ChangesTest, AFileIsRefusedWithPlaceKeyAndRemedy) {
  const auto refused = [&](const std::string& keys) -> std::string {
    WriteFile(folder_ / "s.yaml", "mission: landing\nstart: {height_m: 5}\n" + keys);
    try {
      LoadScenario(folder_ / "s.yaml", {}, false);
    } catch (const InputError& e) {
      return e.what();
    }
    return "taken";
  };
  const std::string wind = "changeable:\n  - {key: wind.mean_m_s, max: 8}\n";
  EXPECT_EQ(refused(wind + "changes: [{at_s: 1, key: wind.mean_m_s, value: 5}]\n"), "taken");
  EXPECT_THAT(
      refused("changeable: [{key: seed}]\n"),
      HasSubstr("s.yaml:3: changeable.0.key: 'seed' cannot be changed in flight; valid: wind.mean_m_s"));
  EXPECT_THAT(refused("changeable: [{key: flight.limits.tilt_deg}]\n"), HasSubstr("cannot be changed"));
  EXPECT_THAT(refused("changeable: [{key: wind.mean}]\n"),
              HasSubstr("changeable.0.key: this scenario has no key 'wind.mean'"));
  EXPECT_THAT(refused("changeable: [{key: targets.0.speed}]\n"), HasSubstr("has no key"));
  EXPECT_EQ(refused("changeable: [{key: targets.0.velocity_m_s}]\n"), "taken");  // where there are none
  EXPECT_THAT(
      refused("changeable:\n  - {key: wind.mean_m_s, max: 80}\n"),
      HasSubstr("s.yaml:4: changeable.0.max: 80 is out of the range of wind.mean_m_s; valid: 0 to 20"));
  EXPECT_THAT(refused("changeable: [{key: sensors.faults, min: 0}]\n"), HasSubstr("is no number"));
  EXPECT_THAT(refused(wind + wind.substr(12)), HasSubstr("given twice"));
  EXPECT_THAT(
      refused(wind + "changes:\n  - {at_s: 1, key: wind.mean_m_s, value: 9}\n"),
      HasSubstr("s.yaml:6: changes.0.value: wind.mean_m_s: 9 is out of the range that changeable gives "
                "it; valid: 0 to 8"));
  EXPECT_THAT(
      refused(wind + "changes:\n  - {at_s: 1, key: wind.from_deg, value: 9}\n"),
      HasSubstr("s.yaml:6: changes.0.key: wind.from_deg: is not among what this scenario lets change in "
                "flight; valid: wind.mean_m_s"));
  EXPECT_THAT(refused("changes: [{at_s: 1, key: wind.from_deg, value: 9}]\n"),
              HasSubstr("valid: none, as it has no `changeable`"));
  EXPECT_THAT(refused("changes: [{at_s: -1, key: wind.from_deg}]\n"),
              HasSubstr("changes.0.value: must be given"));
}

}  // namespace
}  // namespace kestrel::flight
