// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_physics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "records/summary.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// Has one autopilot, which leaves at a time of its own.
class OnePeer final : public sim::PhysicsServer {
 public:
  explicit OnePeer(double leaves_s) : leaves_s_(leaves_s) {}
  bool Begin() override { return begun++ < 1 || last_s < leaves_s_; }
  std::optional<double> step_s() const override { return 0.001; }
  std::optional<sim::Actuation> Step(double dt_s, const sim::SensorReadings&, const Truth& truth) override {
    last_s = truth.t_s;
    last_dt_s = dt_s;
    if (last_s >= leaves_s_) return std::nullopt;
    return sim::Actuation{};
  }
  void Stop() override {}
  std::string Where() const override { return "udp://127.0.0.1:1"; }
  sim::PhysicsCounts counts() const override { return {}; }

  int begun = 0;
  double last_s = 0, last_dt_s = 0;

 private:
  const double leaves_s_;
};

TEST(ServePhysics, AFlightLastsUntilItsAutopilotLeavesBeyondTheScenariosDuration) {
  const LoadedScenario loaded = LoadScenario("hover", {"criteria={}", "duration_s=0.2", "image.rate_hz=5",
                                                       "image.faults=[{type: intermittent, rate_per_min: 60, "
                                                       "length_s: 1, loss: 0.5}]"});
  OnePeer peer(1.5);
  int frames = 0, flights = 0;
  PhysicsOptions options;
  options.publish = [&](const vision::Frame&) { ++frames; };
  options.say = [&](const std::string& line) {
    flights += line.find("an autopilot is there") != std::string::npos;
  };
  ServePhysics(loaded, peer, options);
  EXPECT_EQ(flights, 1);
  EXPECT_NEAR(peer.last_s, 1.5, 0.01);
  EXPECT_EQ(peer.last_dt_s, 0.001);  // as it asked for
  EXPECT_GE(frames, 1);
}

// Flies each flight by the truth: up to a height, down again, motors off, and leaves. A height of 0: it stands.
class HoppingPeer final : public sim::PhysicsServer {
 public:
  HoppingPeer(sim::MultirotorParameters aircraft, std::vector<double> heights_m)
      : aircraft_(std::move(aircraft)), heights_m_(std::move(heights_m)) {}
  bool Begin() override {
    begun_ = landed_ = false;
    return flights_++ < heights_m_.size();
  }
  std::optional<double> step_s() const override { return 0.002; }
  std::optional<sim::Actuation> Step(double, const sim::SensorReadings&, const Truth& truth) override {
    if (!begun_) stood_m_ = truth.X_NB.p.z();
    begun_ = true;
    const double height_m = heights_m_[flights_ - 1];
    const bool down = truth.t_s > 3;
    landed_ = landed_ || (down && truth.touching);
    if (truth.t_s >= leaves_s) return std::nullopt;
    if (height_m == 0 || landed_ || truth.t_s < 0.3 || (falls && down)) return sim::Actuation{};
    highest_m = std::max(highest_m, stood_m_ - truth.X_NB.p.z());
    const double sinks_m_s = down ? 0.4 : 1.5 * (height_m - (stood_m_ - truth.X_NB.p.z())) * -1;
    const double thrust = aircraft_.mass_kg * (9.81 - 4 * (sinks_m_s - truth.v_N.z()));
    const Eigen::Vector3d up_B = truth.X_NB.R.conjugate() * Eigen::Vector3d(0, 0, -1);
    const double since_s = truth.t_s - 1, lean = std::abs(since_s) < 0.2 ? std::copysign(0.1, since_s) : 0;
    const Eigen::Vector3d torque_B =
        2.0 * Eigen::Vector3d(std::sin(lean), 0, -std::cos(lean)).cross(up_B) - 0.4 * truth.w_B;
    return sim::Allocate(aircraft_, std::max(thrust, 1.0), torque_B);
  }
  void Stop() override {}
  std::string Where() const override { return "udp://127.0.0.1:1"; }
  sim::PhysicsCounts counts() const override { return {}; }

  double leaves_s = 7, highest_m = 0;
  bool falls = false;  // it does not sink, but stops its motors

 private:
  sim::MultirotorParameters aircraft_;
  std::vector<double> heights_m_;
  std::size_t flights_ = 0;
  bool begun_ = false, landed_ = false;
  double stood_m_ = 0;
};

class PhysicsRecordsTest : public InTemporaryFolder {
 protected:
  static LoadedScenario Calm(const std::vector<std::string>& more) {
    std::vector<std::string> overrides = {"seed=11",
                                          "image.rate_hz=5",
                                          "start.scatter_m=0.3",
                                          "duration_s=3",
                                          "wind.turbulence=false",
                                          "wind.mean_m_s=0",
                                          "wind.gusts.rate_per_min=0"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    return LoadScenario("landing", overrides);
  }
  static HoppingPeer Peer(const LoadedScenario& loaded, std::vector<double> heights_m) {
    return {std::get<sim::MultirotorParameters>(loaded.simulator.vehicle), std::move(heights_m)};
  }
  std::string Content(const char* file) const {
    std::ifstream in(folder_ / file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
};

TEST_F(PhysicsRecordsTest, AFlightByPhysicsIsRecordedAndJudgedByTheTruth) {
  const LoadedScenario loaded =
      Calm({"criteria={touchdown_error_m: {max: 1}, touchdown_sink_m_s: {max: 1}, "
            "rest_error_m: {max: 1}, fix_share: {min: 0.5}}"});
  HoppingPeer peer = Peer(loaded, {0.9});
  PhysicsOptions options;
  options.folder = folder_ / "run";
  std::vector<std::filesystem::path> told;
  options.over = [&](const records::Summary&, const auto& folder) { told.push_back(*folder); };
  const std::vector<PhysicsFlight> flights = ServePhysics(loaded, peer, options);
  ASSERT_GT(peer.highest_m, 0.6);
  ASSERT_EQ(flights.size(), 1u);
  const records::Summary& s = flights[0].summary;
  EXPECT_TRUE(flights[0].flown);
  EXPECT_EQ(s.outcome, "landed");
  EXPECT_TRUE(s.passed);
  EXPECT_NEAR(s.sim_s, 7, 0.01);
  EXPECT_EQ(s.criteria.size(), 3u);  // fix_share is left out
  EXPECT_GT(s.metrics.at("touchdown_s"), 3);
  EXPECT_NEAR(s.metrics.at("touchdown_sink_m_s"), 0.4, 0.2);
  EXPECT_EQ(StatusOf(flights), 0);
  EXPECT_THAT(told, ElementsAre(folder_ / "run"));
  for (const char* file : {"run/video.mp4", "run/page.json", "run/plots/position.png"})
    EXPECT_TRUE(std::filesystem::exists(folder_ / file)) << file;
  const records::Summary written = records::ReadSummary(folder_ / "run/summary.json");
  EXPECT_EQ(written.outcome, "landed");
  EXPECT_EQ(written.metrics.at("rest_error_m"), s.metrics.at("rest_error_m"));
  EXPECT_THAT(Content("run/scenario.yaml"), HasSubstr("duration_s: 3\n"));  // not for ever
  const std::string events = Content("run/events.log");
  EXPECT_THAT(events, HasSubstr("moves the rotors itself; physics of 500 Hz"));
  EXPECT_THAT(events, HasSubstr("fix_share is left out"));
  EXPECT_THAT(events, HasSubstr("skids clear"));
  EXPECT_THAT(events, HasSubstr("end: landed"));
  EXPECT_THAT(events, Not(HasSubstr("navigation")));  // the emulated autopilot's, which does not fly
  // What the autopilot estimates nobody knows; the tilt is the most of all rows, though few are kept.
  std::istringstream telemetry(Content("run/telemetry.csv"));
  std::string line;
  std::getline(telemetry, line);
  std::vector<std::string> names;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) names.push_back(name);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  double most_deg = 0, highest_m = 0;
  int rows = 0;
  for (; std::getline(telemetry, line); ++rows) {
    std::vector<std::string> cells;
    std::istringstream cut(line);
    for (std::string cell; std::getline(cut, cell, ',');) cells.push_back(cell);
    EXPECT_EQ(cells.at(column("estimate_x_m")), "");
    EXPECT_EQ(cells.at(column("mode")), "");
    const double roll = std::stod(cells.at(column("truth_roll_deg"))) * M_PI / 180,
                 pitch = std::stod(cells.at(column("truth_pitch_deg"))) * M_PI / 180;
    most_deg = std::max(most_deg, std::acos(std::cos(roll) * std::cos(pitch)) * 180 / M_PI);
    highest_m = std::max(highest_m, -std::stod(cells.at(column("truth_z_m"))));
  }
  EXPECT_EQ(rows, 35);
  EXPECT_GT(highest_m, 0.6);
  EXPECT_GT(most_deg, 1);
  EXPECT_NEAR(s.metrics.at("max_tilt_deg"), most_deg, 1e-3);
}

TEST_F(PhysicsRecordsTest, FurtherFlightsHaveFoldersOfTheirOwnAndOneThatStoodIsNotFlown) {
  const LoadedScenario loaded = Calm({"criteria={max_tilt_deg: {max: 90}}"});
  HoppingPeer peer = Peer(loaded, {0, 0.9, 0});
  peer.leaves_s = 2.5;  // in the air
  PhysicsOptions options;
  options.folder = folder_ / "run/";
  options.video = false;
  const std::vector<PhysicsFlight> flights = ServePhysics(loaded, peer, options);
  ASSERT_EQ(flights.size(), 3u);
  EXPECT_EQ(records::ReadSummary(folder_ / "run/summary.json").outcome, "not flown");
  EXPECT_EQ(records::ReadSummary(folder_ / "run-2/summary.json").outcome, "the autopilot left, in the air");
  EXPECT_EQ(records::ReadSummary(folder_ / "run-3/summary.json").outcome, "not flown");
  EXPECT_FALSE(flights[0].summary.passed);
  EXPECT_TRUE(flights[1].summary.passed);
  EXPECT_EQ(StatusOf(flights), 0);  // by those that were flown
}

TEST_F(PhysicsRecordsTest, ACrashIsNoFlightThatHasPassedThoughNoCriterionSaysSo) {
  const LoadedScenario loaded = Calm({"criteria={}"});
  HoppingPeer peer = Peer(loaded, {1.2});
  peer.falls = true;
  const std::vector<PhysicsFlight> flights = ServePhysics(loaded, peer, {});
  ASSERT_EQ(flights.size(), 1u);
  EXPECT_EQ(flights[0].summary.outcome, "crashed");
  EXPECT_FALSE(flights[0].summary.passed);
  EXPECT_EQ(StatusOf(flights), 1);
}

TEST_F(PhysicsRecordsTest, TheStatusIsOfWhatWasFlown) {
  PhysicsFlight met, missed, stood, broken;
  met.flown = missed.flown = true;
  met.summary.complete = met.summary.passed = missed.summary.complete = stood.summary.complete = true;
  EXPECT_EQ(StatusOf({}), 1);
  EXPECT_EQ(StatusOf({stood}), 1);
  EXPECT_EQ(StatusOf({stood, met}), 0);
  EXPECT_EQ(StatusOf({missed, met}), 1);
  EXPECT_EQ(StatusOf({met, broken}), 3);
}

TEST_F(PhysicsRecordsTest, AnEndFromOutsideIsSaid) {
  const LoadedScenario loaded = Calm({"criteria={}"});
  HoppingPeer peer = Peer(loaded, {0.9});
  peer.leaves_s = 2.5;
  PhysicsOptions options;
  options.stopped = [] { return true; };
  EXPECT_EQ(ServePhysics(loaded, peer, options).at(0).summary.outcome, "ended from outside, in the air");
}

TEST(ServePhysics, FaultsThatCannotReachTheAutopilotAreRefusedAllAtOnce) {
  const LoadedScenario loaded = LoadScenario(
      "hover",
      {"criteria={}",
       "sensors.faults=[{component: gps, type: off}, {component: gyro, type: stuck}, {component: baro, type: "
       "wrong}, {component: mag, type: off}, {component: mag, type: ok}]"});
  Mistakes of_ardupilot, of_px4;
  CheckPhysicsFaults("ardupilot", loaded, of_ardupilot);
  CheckPhysicsFaults("px4", loaded, of_px4);
  ASSERT_EQ(of_ardupilot.all().size(), 3U);
  EXPECT_EQ(of_ardupilot.all()[0].key, "sensors.faults.0.component");
  EXPECT_EQ(of_ardupilot.all()[1].key, "sensors.faults.2.component");
  EXPECT_EQ(of_ardupilot.all()[2].key, "sensors.faults.3.component");
  EXPECT_EQ(of_ardupilot.all()[0].what.substr(0, 4), "gps:");
  EXPECT_FALSE(of_ardupilot.all()[0].remedy.empty());
  EXPECT_TRUE(of_px4.empty());
}

TEST(ServePhysics, AFaultOfTheEmulatedAttitudeIsRefusedForBothAutopilots) {
  const LoadedScenario loaded =
      LoadScenario("hover", {"criteria={}", "sensors.attitude_faults=[{type: freeze}]"});
  for (const char* const kind : {"ardupilot", "px4"}) {
    Mistakes mistakes;
    CheckPhysicsFaults(kind, loaded, mistakes);
    ASSERT_EQ(mistakes.all().size(), 1U) << kind;
    EXPECT_EQ(mistakes.all()[0].key, "sensors.attitude_faults.0");
  }
}

}  // namespace
}  // namespace kestrel::flight
