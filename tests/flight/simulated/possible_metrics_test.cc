// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/possible_metrics.h"

#include <gmock/gmock.h>

#include "base/file/model_files.h"
#include "flight/simulated/runner.h"
#include "records/telemetry/metrics.h"
#include "scenarios/flights.h"

namespace kestrel::flight {
namespace {

using ::testing::Contains;
using ::testing::IsSubsetOf;
using ::testing::IsSupersetOf;
using ::testing::Not;

std::vector<std::string> Keys(const std::map<std::string, double>& metrics) {
  std::vector<std::string> names;
  for (const auto& [name, value] : metrics) names.push_back(name);
  return names;
}

// Some frames of each mission: what they had is possible, and what it is known for is among that. The log
// tells of a goal what only longer flights have metrics of.
TEST(PossibleMetrics, HoldWhatFlightsOfEachMissionHave) {
  const std::map<std::string, std::vector<std::string>> known = {
      {"pose", {"fix_x_rmse_m", "longest_loss_s", "fix_autopilot_x_rms_m"}},
      {"hover", {"fix_x_rmse_m", "longest_loss_s"}},
      {"landing", {"fix_x_rmse_m", "longest_loss_s", "within_limits_or_aborted"}},
      {"landing_deck", {"deck_max_speed_m_s", "within_limits_or_aborted"}},
      {"attitude_1", {"roll_rmse_deg", "yaw_rmse_deg"}},
      {"gyro_failure", {"roll_rmse_deg", "failure_tilt_rms_deg"}},
      {"follow", {"in_view_share", "followed_share"}},
      {"avoid", {"closest_m", "manoeuvred"}},
      {"vicon_1", {"landmark_z_rmse_m", "chain_drift_m"}},
      {"stabilise", {"path_horizontal_rmse_m"}},
      {"survey", {"path_vertical_rmse_m"}},
      {"panorama", {"path_yaw_rmse_deg"}},
      {"servo", {"servo_converged", "fix_x_rmse_m"}},
      {"hover_direct", {"direct_share", "fix_x_rmse_m"}},
      {"hover_ground_camera", {"fix_x_rmse_m", "longest_loss_s"}},
      {"landing_ground_camera", {"fix_x_rmse_m", "longest_loss_s"}},
      {"landing_hybrid", {"fix_x_rmse_m", "by_ground_alone_share"}},
      {"ground_calibration", {"fix_x_rmse_m"}}};
  scenarios::AddFlights();
  ASSERT_EQ(known.size(), mission::MissionNames().size());
  for (const auto& [name, telling] : known) {
    std::vector<std::string> overrides = {"duration_s=0.4", "start.settle_s=0.2", "image.rate_hz=10",
                                          "criteria={}"};
    if (name == "gyro_failure") overrides.push_back("sensors.attitude_faults.0.from_s=0.1");
    const LoadedScenario loaded = LoadScenario(name, overrides);
    const FlightResult flight = RunFlight(loaded, {});
    ASSERT_EQ(flight.summary.error, "") << name;
    const std::vector<std::string> possible = PossibleMetrics(loaded.scenario);
    EXPECT_THAT(Keys(flight.summary.metrics), IsSubsetOf(possible)) << name;
    EXPECT_THAT(Keys(flight.summary.metrics), IsSupersetOf(telling)) << name;
    EXPECT_THAT(possible, IsSubsetOf(KnownMetrics()));
    bool goal = false;
    for (const records::LogRow& row : flight.rows) goal = goal || row.decision.goal_T;
    EXPECT_EQ(std::count(possible.begin(), possible.end(), "settle_s"), goal) << name;
    const bool lands = name.starts_with("landing");
    EXPECT_EQ(std::count(possible.begin(), possible.end(), "touchdown_error_m"), lands) << name;
    EXPECT_EQ(std::count(possible.begin(), possible.end(), "hold_yaw_rmse_deg"), goal && !lands) << name;
  }
}

// What each file asks of its flight, which meets it.
TEST(PossibleMetrics, HoldWhatEveryScenarioIsJudgedBy) {
  for (const std::string& name : ScenarioNames()) {
    const Scenario scenario = LoadScenario(name, {}, false).scenario;
    const std::vector<std::string> possible = PossibleMetrics(scenario);
    for (const auto& [metric, limit] : scenario.criteria) EXPECT_THAT(possible, Contains(metric)) << name;
  }
}

TEST(PossibleMetrics, DependOnWhatTheFlightIsToDoOrMayBe) {
  const auto of = [](const char* name, const std::vector<std::string>& set, const std::string& varies = "") {
    return PossibleMetrics(LoadScenario(name, set, false).scenario,
                           [&](const std::string& key) { return key == varies; });
  };
  EXPECT_THAT(of("attitude_1", {"flight.baseline=false"}), Not(Contains("baseline_roll_rmse_deg")));
  EXPECT_THAT(of("attitude_1", {"flight.baseline=true"}), Contains("baseline_roll_rmse_deg"));
  EXPECT_THAT(of("attitude_1", {}, "flight.baseline"), Contains("baseline_roll_rmse_deg"));
  EXPECT_THAT(of("follow", {}), Not(Contains("step_u_settle_s")));
  EXPECT_THAT(of("follow", {}, "flight.reference"), Contains("step_u_settle_s"));
  EXPECT_THAT(of("follow_step", {}), Contains("step_u_settle_s"));
  EXPECT_THAT(of("hover", {}), Not(Contains("failure_noticed_s")));
  EXPECT_THAT(of("hover", {}, "sensors.attitude_faults"), Contains("failure_noticed_s"));
}

}  // namespace
}  // namespace kestrel::flight
