// SPDX-License-Identifier: Apache-2.0
#include "scenarios/attitude/attitude.h"

#include <cmath>
#include <optional>

#include "geometry/tait_bryan.h"
#include "mission/horizon_watch.h"
#include "vision/horizon/skyline_baseline.h"

namespace kestrel {
namespace {

// The ring of the image that the thesis unrolls: of a camera that looks straight down, about the horizon.
CompassBaseline::Ring RingOf(const CameraModel& camera, const Eigen::Matrix3d& R_BC) {
  const auto at = [&](double elevation_deg) {
    const double e = Radians(elevation_deg);
    const Eigen::Vector3d ahead_B(std::cos(e), 0, -std::sin(e));
    return Project(camera, R_BC.transpose() * ahead_B);
  };
  CompassBaseline::Ring ring;
  ring.centre = Parameters(camera).segment<2>(2);
  const auto inner = at(-6), outer = at(10);
  if (inner && outer) {
    ring.radius_inner = (*inner - ring.centre).norm();
    ring.radius_outer = (*outer - ring.centre).norm();
    const Eigen::Vector2d ahead = *outer - ring.centre;
    ring.nose = std::atan2(ahead.y(), ahead.x());
  }
  return ring;
}

class AttitudeMission final : public Mission {
 public:
  AttitudeMission(const AttitudeFlight& flight, const CameraModel& camera, const Pose& X_BC,
                  const cv::Mat& forbidden, std::uint64_t seed)
      : flight_(flight), pilot_(flight.manoeuvres, seed), watch_(camera, X_BC, forbidden) {
    if (!flight.baseline) return;
    skyline_baseline_.emplace(camera, X_BC.R.toRotationMatrix());
    compass_baseline_.emplace(camera, RingOf(camera, X_BC.R.toRotationMatrix()));
  }

  Decision Step(const Frame& frame, const VehicleState& state) override {
    Decision decision;
    watch_.See(frame, state, decision);
    if (skyline_baseline_) Compare(frame, decision);
    Steer(state, decision);
    return decision;
  }
  bool Accomplished() const override { return watch_.seen(); }
  // The skyline is measured, and nothing flown by it.
  TargetNeed Target() const override { return TargetNeed::kNone; }
  void Draw(cv::Mat& bgr) const override { watch_.Draw(bgr); }

 private:
  // The thesis's own way, on the same image.
  void Compare(const Frame& frame, Decision& decision) {
    AttitudeFix fix{};
    fix.turned = compass_baseline_->Turn(frame.image);
    if (const auto attitude = skyline_baseline_->Measure(frame.image)) {
      fix.roll = attitude->roll, fix.pitch = attitude->pitch;
      decision.baseline = fix;
    }
  }

  void Steer(const VehicleState& state, Decision& decision) {
    if (!home_N_) home_N_ = state.p_NB, home_yaw_ = YawOf(state.R_NB);
    if (state.landed && state.t_s < flight_.take_off_s) {
      decision.phase = "run up";
      return;
    }
    if (state.t_s < flight_.manual_from_s) {
      const bool from_ground = flight_.take_off_s > 0;
      decision.phase = from_ground ? "take off" : "hold";
      decision.setpoint = PositionSetpoint{
          {home_N_->x(), home_N_->y(), home_N_->z() - (from_ground ? flight_.take_off_height_m : 0)},
          home_yaw_};
      return;
    }
    decision.phase = "by hand";
    decision.setpoint = pilot_.Fly(state, {home_N_->x(), home_N_->y(), 0});
  }

  AttitudeFlight flight_;
  ManualPilot pilot_;
  HorizonWatch watch_;
  std::optional<SkylineBaseline> skyline_baseline_;
  std::optional<CompassBaseline> compass_baseline_;
  std::optional<Eigen::Vector3d> home_N_;
  double home_yaw_ = 0;
};

}  // namespace

std::unique_ptr<Mission> MakeMission(const AttitudeFlight& flight, const CameraModel& camera,
                                     const Pose& X_BC, const cv::Mat& forbidden, std::uint64_t seed) {
  return std::make_unique<AttitudeMission>(flight, camera, X_BC, forbidden, seed);
}

}  // namespace kestrel
