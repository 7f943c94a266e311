// SPDX-License-Identifier: Apache-2.0
// Flights by a camera on the ground, judged by the simulator's truth, on seeds that nothing was chosen by.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>

#include "base/diagnostics.h"
#include "flight/simulated/scenario.h"
#include "geometry/tait_bryan.h"
#include "mission/flight_loop.h"
#include "sim/simulator.h"
#include "tests/acceptance/flown.h"
#include "tests/support/temporary_folder.h"
#include "vision/aircraft/ground_camera.h"

namespace kestrel {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Pose InPadFrame(const Truth& t) { return t.X_NT.Inverse() * t.X_NB; }

double HoverRms_m(const flight::FlightResult& result, double from_s, double height_m) {
  double squared = 0;
  int count = 0;
  for (const records::LogRow& row : result.rows) {
    if (row.now.t_s < from_s) continue;
    squared += (InPadFrame(row.now).p - Eigen::Vector3d(0, 0, -height_m)).squaredNorm();
    ++count;
  }
  EXPECT_GT(count, 20);
  return std::sqrt(squared / std::max(1, count));
}

TEST(GroundCameraFlights, HoverByAMastThatIsWhereItIsSaidToBe) {
  const flight::FlightResult flight =
      Flown("hover_ground_camera", 101,
            {"duration_s=14", "start.height_m=3", "start.scatter_m=0.3", "ground_view.error.position_m=0",
             "ground_view.error.angle_deg=0"});
  EXPECT_LT(HoverRms_m(flight, 8, 3), 0.15);
  EXPECT_GT(flight.summary.metrics.at("fix_share"), 0.9);
}

TEST(GroundCameraFlights, AHeadKeepsTheAircraftInTheImageOfALongLens) {
  const flight::FlightResult flight =
      Flown("hover_ground_camera", 102,
            {"duration_s=10", "start.height_m=5.5", "flight.height_m=2", "ground_camera.camera=ground_12mm",
             "ground_view.head.rate_deg_s=60"});
  EXPECT_GT(flight.summary.metrics.at("fix_share"), 0.9);
  EXPECT_LT(-InPadFrame(flight.rows.back().now).p.z(), 3);
}

TEST(GroundCameraFlights, EitherCameraLandsItWhileTheOtherIsBlocked) {
  const std::vector<std::string> low = {"start.height_m=2", "start.scatter_m=0.3", "duration_s=30"};
  for (const char* blocked :
       {"occlusion={share: 1, from_s: 2, until_s: 30}", "ground_view.blocked=[{from_s: 2, until_s: 30}]"}) {
    std::vector<std::string> overrides = {"occlusion={share: 0}", "ground_view.blocked=[]"};
    overrides.insert(overrides.end(), low.begin(), low.end());
    overrides.push_back(blocked);
    const flight::FlightResult flight = Flown("landing_hybrid", 103, overrides);
    EXPECT_EQ(flight.summary.outcome, "landed") << blocked;
    EXPECT_LT(flight.summary.metrics.at("touchdown_error_m"), 0.3) << blocked;
  }
}

TEST(GroundCameraFlights, AClockThatIsApartIsNamedAndItsCameraNotFlownBy) {
  const flight::FlightResult flight = Flown(
      "landing_hybrid", 104,
      {"duration_s=30", "occlusion={share: 0}", "ground_view.blocked=[]", "ground_view.clock_offset_s=3"});
  EXPECT_EQ(flight.summary.outcome, "landed");
  for (const records::LogRow& row : flight.rows) EXPECT_NE(row.decision.target, "both");
  EXPECT_EQ(flight.rows[flight.rows.size() / 2].decision.target, "board, clock");
}

TEST(GroundCameraFlights, AClockThatLagsIsFoundFromTheMotionAndTheAircraftStaysWhereItIs) {
  const flight::FlightResult flight =
      Flown("hover_ground_camera", 106, {"duration_s=16", "ground_view.clock_offset_s=-0.3"});
  ASSERT_EQ(flight.rows.back().decision.target, "clock apart");
  EXPECT_EQ(flight.rows.back().decision.phase, "search");
  const auto apart = std::find_if(flight.rows.begin(), flight.rows.end(), [](const records::LogRow& row) {
    return row.decision.target == "clock apart";
  });
  for (auto row = apart; row != flight.rows.end(); ++row) {
    EXPECT_EQ(row->decision.target, "clock apart");
    EXPECT_LT((InPadFrame(row->now).p - InPadFrame(apart->now).p).norm(), 1.5);
  }
}

TEST(GroundCameraFlights, AStartThatTheCameraDoesNotSeeIsRefusedWithTheRemedy) {
  const auto refusal = [](const std::vector<std::string>& overrides) -> std::string {
    try {
      flight::LoadScenario("landing_ground_camera", overrides, false);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({}), "");
  EXPECT_THAT(refusal({"ground_view.place.yaw_deg=90"}),
              AllOf(HasSubstr("ground_view.place"), HasSubstr("does not see the start")));
  EXPECT_THAT(refusal({"ground_view.place=null", "ground_camera.place.yaw_deg=90"}),
              AllOf(HasSubstr("ground_camera.place"), HasSubstr("does not see the start")));
  EXPECT_THAT(refusal({"ground_view.place.position_m=[-90, 0, 2]"}), HasSubstr("a nearer place"));
  EXPECT_THAT(refusal({"ground_camera=null"}), HasSubstr("flies by a camera on the ground"));
  EXPECT_THAT(refusal({"ground_view.image.colour=false"}), HasSubstr("told by their colours"));
  EXPECT_THAT(refusal({"ground_view.blocked=[{from_s: 5, until_s: 4}]"}), HasSubstr("until_s after from_s"));
}

class GroundCalibration : public InTemporaryFolder {};

TEST_F(GroundCalibration, FindsTheMastWithinItsOwnSigmas) {
  const flight::LoadedScenario loaded = flight::LoadScenario("ground_calibration", {"seed=105"});
  sim::Simulator simulator(loaded.simulator);
  mission::MissionParts parts = flight::PartsOf(loaded, simulator.model());
  parts.ground->stream = simulator.ground_camera();
  const std::unique_ptr<mission::Mission> mission = loaded.scenario.flight->Make(parts);
  const std::string outcome = mission::Fly(simulator, simulator, *mission,
                                           [](const auto&, const auto&, const auto&) { return true; });
  EXPECT_EQ(outcome, "calibrated");
  mission->WriteProducts(folder_);
  std::vector<std::string> lines;
  std::ifstream file(folder_ / "ground_place.yaml");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    line = line.substr(0, line.find("  #"));
    lines.push_back(line.replace(line.find(": "), 2, "="));
  }
  const flight::LoadedScenario found = flight::LoadScenario("landing_ground_camera", lines, false);
  const vision::GroundPlace& place = found.simulator.ground->place;
  const Pose X_NT = simulator.truth().X_NT;
  const Pose truth = X_NT.Inverse() * simulator.ground_camera()->X_NC();
  const Pose believed = vision::CameraPose(vision::MastPose(place), {});
  EXPECT_LT((truth.p - believed.p).norm(), 4 * std::sqrt(3) * place.position_sigma_m);
  EXPECT_LT(truth.R.angularDistance(believed.R), Radians(4 * std::sqrt(3) * place.angle_sigma_deg));
  EXPECT_LT((truth.p - believed.p).norm(), 0.15);  // it was 0.3 m and 1.5 degrees in each coordinate
}

}  // namespace
}  // namespace kestrel
