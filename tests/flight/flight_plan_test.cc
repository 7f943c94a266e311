// SPDX-License-Identifier: Apache-2.0
#include "flight/flight_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/yaml/fields.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/scenario.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::HasSubstr;

using FlightPlanTest = InTemporaryFolder;

// Collects the names of fields, those of the parts "image" and "pad" with their part.
struct Names final : FieldVisitor {
  explicit Names(std::string of = "") : prefix(std::move(of)) {}
  void Visit(const FieldKey& key, const FieldValue& field) override {
    const std::string name(key.name);
    const auto* part = std::get_if<StructField>(&field);
    if (!part || !prefix.empty() || (name != "image" && name != "pad")) {
      all.insert(prefix + name);
      return;
    }
    Names inner(name + ".");
    part->Visit(inner);
    all.merge(inner.all);
  }
  std::set<std::string> all;
  std::string prefix;
};

template <class T>
std::set<std::string> NamesOf(T value) {
  Names names;
  Fields(names, value);
  return names.all;
}

TEST_F(FlightPlanTest, EveryKeyOfAScenarioIsOfThePlanOrOfTheWorld) {
  Scenario scenario;
  scenario.mission = "landing";
  FlightPlan plan;
  plan.mission = "landing";
  std::set<std::string> known = NamesOf(plan);
  known.erase("own_parts");  // of a real aircraft alone
  for (const std::string_view key : WorldKeys())
    EXPECT_TRUE(known.emplace(key).second) << key << " is of both";
  EXPECT_EQ(NamesOf(scenario), known);
}

TEST_F(FlightPlanTest, IsWhatTheScenarioSays) {
  for (const char* name : {"landing", "hover", "follow", "attitude_1", "avoid_left_1"}) {
    const LoadedScenario scenario = LoadScenario(name);
    const LoadedPlan plan = LoadPlan(name);
    EXPECT_EQ(plan.plan.mission, scenario.scenario.mission);
    EXPECT_EQ(plan.plan.image.colour, scenario.scenario.image.colour);
    EXPECT_EQ(plan.plan.duration_s, scenario.scenario.duration_s);
    EXPECT_EQ(plan.parts.X_BC.p, vision::MountPose(scenario.scenario.mount).p);
    EXPECT_EQ(ToYaml(plan.plan.pilot), ToYaml(scenario.scenario.pilot));
    EXPECT_EQ(&plan.plan.flight.type(), &scenario.scenario.flight.type());
    EXPECT_EQ(vision::WidthPx(plan.parts.camera), vision::WidthPx(scenario.simulator.camera));
  }
}

// A real aircraft flies by the gains that the simulator flies by; those of the world's keys are passed over.
TEST_F(FlightPlanTest, GainsOfAFileAreOfThePlanToo) {
  WriteFile(folder_ / "gains.yaml", "pilot.servo.lambda_per_s: 0.9\nautopilot.velocity_gain_per_s: 0.7\n");
  const std::string file = (folder_ / "flight.yaml").string();
  WriteFile(file, "mission: hover\ngains: gains.yaml\n");
  EXPECT_EQ(LoadPlan(file).plan.pilot.servo.lambda_per_s, 0.9);
  EXPECT_EQ(LoadPlan(file, {"pilot.servo.lambda_per_s=0.8"}).plan.pilot.servo.lambda_per_s, 0.8);
  WriteFile(folder_ / "gains.yaml", "pilot.servo.lambda_per: 0.9\n");
  try {
    LoadPlan(file);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("gains.yaml:1: pilot.servo.lambda_per: unknown key"));
  }
}

TEST_F(FlightPlanTest, ReadsItsOwnWords) {
  const LoadedPlan plan = LoadPlan("landing", {"flight.descent_m_s=0.4", "mount.yaw_deg=90"});
  WriteFile(folder_ / "again.yaml", ToYaml(plan.plan));
  EXPECT_EQ(ToYaml(LoadPlan((folder_ / "again.yaml").string()).plan), ToYaml(plan.plan));
}

TEST_F(FlightPlanTest, AMisspeltKeyIsNotTakenForTheWorlds) {
  try {
    LoadPlan("landing", {"flight.decent_m_s=0.4", "image.color=true", "wnd.mean_m_s=3"});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("descent_m_s"));
    EXPECT_THAT(e.what(), HasSubstr("colour"));
    EXPECT_THAT(e.what(), HasSubstr("wnd"));
  }
}

TEST_F(FlightPlanTest, AFlightThatTellsColoursNeedsThem) {
  EXPECT_THROW(LoadPlan("follow", {"image.colour=false"}), InputError);
  EXPECT_THROW(LoadPlan("landing", {"pad.name=none"}), InputError);
}

TEST_F(FlightPlanTest, OwnPartsMustBeOfTheCamera) {
  EXPECT_THROW(LoadPlan("attitude_1", {"own_parts=/nowhere.png"}), InputError);
}

}  // namespace
}  // namespace kestrel::flight
