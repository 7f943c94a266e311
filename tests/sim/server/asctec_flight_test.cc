// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "sim/autopilot/emulated_autopilot.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"
#include "sim/world/wind.h"
#include "tests/sim/pelican_over_a_plane.h"
#include "tests/sim/perfect_sensors.h"
#include "tests/sim/server/asctec_line.h"

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

// An aircraft with its emulated autopilot, in air.
class Pelican final : public Autopilot {
 public:
  Pelican(const Pose& X_NB, bool flying, const sim::WindParameters& wind,
          const sim::SensorParameters& sensors, std::uint64_t seed)
      : model_(sim::PelicanOverAPlane()),
        data_(mj_makeData(model_.get())),
        vehicle_({}, model_.get()),
        wind_(wind, seed),
        sensors_(sensors, seed),
        autopilot_({}, sensors, sim::MultirotorParameters{}, X_NB, flying, Vector3d::Zero()) {
    sim::PoseToMujoco(X_NB, data_->qpos);
    mj_forward(model_.get(), data_.get());
  }
  VehicleState State() const override { return autopilot_.State(); }
  void Send(const Setpoint& setpoint) override { autopilot_.Send(setpoint); }
  void Aid(const AttitudeAid& aid) override { autopilot_.Aid(aid); }

  void Step() {
    const Vector3d before = v_N();
    wind_.Step(kTick_s, -X_NB().p.z(), before);
    vehicle_.Apply(data_.get(), kTick_s, wind_.Velocity(), 0);
    mj_step(model_.get(), data_.get());
    const Vector3d force_B = X_NB().R.conjugate() * ((v_N() - before) / kTick_s - Vector3d(0, 0, 9.80665));
    const Vector3d w_B = sim::VectorFromMujoco(data_->qvel + 3);
    vehicle_.Command(std::get<sim::RotorSpeeds>(
        autopilot_.Step(kTick_s, sensors_.Read(kTick_s, X_NB(), v_N(), w_B, force_B))));
  }
  Pose X_NB() const { return sim::PoseFromMujoco(data_->qpos); }
  Vector3d v_N() const { return sim::VectorFromMujoco(data_->qvel); }

 private:
  sim::ModelPtr model_;
  sim::DataPtr data_;
  sim::Multirotor vehicle_;
  sim::Wind wind_;
  sim::Sensors sensors_;
  sim::EmulatedAutopilot autopilot_;
};

void FliesVelocitiesAndPlaces(const std::string& mode, FlightMode aircrafts) {
  sim::WindParameters wind;
  wind.mean_m_s = 4, wind.from_deg = 200;
  Pelican pelican({HeadingRotation(0.6), {0, 0, -10}}, true, wind, sim::PerfectSensors(), 1);
  AscTecOptions options;
  options.mode = mode;
  Line line(options);
  const auto step = [&] { pelican.Step(); };
  line.Run(1, pelican, step);
  const Vector3d start = pelican.X_NB().p;
  line.Keep(VelocitySetpoint{{1, 0.5, -0.3}, 0}, 12, pelican, step);
  EXPECT_EQ(pelican.State().mode, aircrafts);
  const Vector3d wanted = HeadingRotation(YawOf(pelican.X_NB().R)) * Vector3d(1, 0.5, -0.3);
  EXPECT_LT((pelican.v_N() - wanted).norm(), 0.1);
  EXPECT_NEAR(YawOf(pelican.X_NB().R), 0.6, 0.05);
  // N of the link begins where the aircraft was first heard of.
  line.Keep(PositionSetpoint{{3, -2, -1}, -0.5}, 25, pelican, step);
  EXPECT_LT((pelican.X_NB().p - start - Vector3d(3, -2, -1)).norm(), 0.3);
  EXPECT_NEAR(YawOf(pelican.X_NB().R), -0.5, 0.05);
}

TEST(AscTecFlight, VelocitiesAndPlacesAreFlownByAttitude) {
  FliesVelocitiesAndPlaces("attitude", FlightMode::kAttitude);
}
TEST(AscTecFlight, VelocitiesAndPlacesAreFlownInTheGpsMode) {
  FliesVelocitiesAndPlaces("gps", FlightMode::kVelocity);
}

TEST(AscTecFlight, TakesOffAndLandsByAttitudeInWindWithRealSensors) {
  for (const std::uint64_t seed : {1, 2}) {
    sim::WindParameters wind;
    wind.mean_m_s = 3, wind.from_deg = 240, wind.turbulence = true, wind.gusts = {6, 2, 3};
    Pelican pelican({HeadingRotation(0.3), {0, 0, -0.16}}, false, wind, {}, seed);
    Line line;
    const auto step = [&] { pelican.Step(); };
    line.Run(1, pelican, step);
    ASSERT_TRUE(line.session.State().landed);
    line.Keep(VelocitySetpoint{{0, 0, -1}, 0}, 1, pelican, step);
    EXPECT_EQ(pelican.State().mode, FlightMode::kStopped);  // only a position takes off
    line.Keep(PositionSetpoint{{0, 0, -2}, 0.3}, 10, pelican, step);
    EXPECT_NEAR(-pelican.X_NB().p.z(), 2.16, 0.6) << seed;
    EXPECT_EQ(line.session.Health(line.t_s).error, "");
    bool landed_in_the_air = false;
    double stopped_s = -1, touched_s = -1;
    const auto watch = [&] {
      pelican.Step();
      const bool up = pelican.X_NB().p.z() < -0.25;
      if (!up && touched_s < 0) touched_s = line.t_s;
      landed_in_the_air |= up && line.session.State().landed;
      if (stopped_s < 0 && line.session.State().landed) stopped_s = line.t_s;
    };
    for (int i = 0; i < 50 && stopped_s < 0; ++i)
      line.Keep(VelocitySetpoint{{0, 0, 0.25}, 0}, 0.5, pelican, watch);
    EXPECT_FALSE(landed_in_the_air) << seed;
    ASSERT_GT(stopped_s, 0) << seed;
    EXPECT_LT(stopped_s - touched_s, 4) << seed;
    EXPECT_TRUE(pelican.State().landed);
    EXPECT_EQ(line.session.Health(line.t_s).error, "");
  }
}

}  // namespace
}  // namespace kestrel::control
