// SPDX-License-Identifier: Apache-2.0
#include "scenarios/attitude/attitude.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "geometry/tait_bryan.h"
#include "sim/stopwatch.h"
#include "vision/horizon_attitude.h"
#include "vision/skyline_baseline.h"

namespace kestrel {
namespace {

// Of the attitude that gyros predict from image to image: they are heard once an image.
constexpr double kPredictionSigma = 0.02;  // rad

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
      : flight_(flight),
        pilot_(flight.manoeuvres, seed),
        horizon_(camera, X_BC.R.toRotationMatrix(), forbidden, {}, {}),
        filter_(HorizonFilterOptions{}) {
    if (!flight.baseline) return;
    skyline_baseline_.emplace(camera, X_BC.R.toRotationMatrix());
    compass_baseline_.emplace(camera, RingOf(camera, X_BC.R.toRotationMatrix()));
  }

  Decision Step(const Frame& frame, const VehicleState& state) override {
    Decision decision;
    See(frame, state, decision);
    Steer(state, decision);
    return decision;
  }
  bool Accomplished() const override { return seen_; }
  void Draw(cv::Mat& bgr) const override {
    if (measured_) bgr = horizon_.Draw(bgr, *measured_);
  }

 private:
  void See(const Frame& frame, const VehicleState& state, Decision& decision) {
    const auto start = std::chrono::steady_clock::now();
    filter_.Add({state.t_s, state.w_B});
    // What gyros and barometer say of the moment of the exposure: to choose and to refuse by.
    HorizonAttitude::Expected expected;
    double yaw = 0;
    if (const auto now = filter_.Now()) {
      const Eigen::Vector3d turned = state.w_B * (state.t_s - frame.t_s);
      const double angle = turned.norm();
      const Eigen::Quaterniond since(
          Eigen::AngleAxisd(angle, angle > 0 ? Eigen::Vector3d(turned / angle) : Eigen::Vector3d::UnitX()));
      const Eigen::Quaterniond R_NB = now->R_NB * since.conjugate();
      expected.down_B = R_NB.conjugate() * Eigen::Vector3d::UnitZ();
      expected.down_sigma = std::hypot(std::sqrt(now->P.topLeftCorner<2, 2>().trace()), kPredictionSigma);
      yaw = YawOf(R_NB);
      if (last_turned_) expected.turn = *last_turned_ + WrapAngle(yaw - last_yaw_);
    }
    expected.height_m = std::max(0.0, -state.p_NB.z());
    measured_ = horizon_.Measure(frame.image, expected);
    const HorizonAttitude::Measurement& m = *measured_;
    decision.target = "horizon";
    if (const auto* reason = std::get_if<NoSkyline>(&m.skyline)) decision.target = NameOf(*reason);
    if (m.attitude) {
      seen_ = true;
      AttitudeFix fix{m.attitude->roll,
                      m.attitude->pitch,
                      std::sqrt(m.attitude->covariance(0, 0)),
                      std::sqrt(m.attitude->covariance(1, 1)),
                      {},
                      0};
      HorizonFilter::Attitude raw{frame.t_s, *m.down_B, m.covariance_B, {}, 0};
      if (const auto* heading = std::get_if<CompassHeading>(&m.compass)) {
        fix.turned = heading->turned;
        fix.turned_sigma = std::sqrt(heading->variance);
        raw.heading = WrapAngle(heading->turned);
        raw.heading_variance = heading->variance;
        last_turned_ = heading->turned, last_yaw_ = yaw;
      }
      filter_.Correct(raw);
      decision.attitude = fix;
    }
    decision.vision_s = SecondsSince(start);
    if (!skyline_baseline_) return;
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
  HorizonAttitude horizon_;
  HorizonFilter filter_;
  std::optional<SkylineBaseline> skyline_baseline_;
  std::optional<CompassBaseline> compass_baseline_;
  std::optional<HorizonAttitude::Measurement> measured_;
  std::optional<Eigen::Vector3d> home_N_;
  double home_yaw_ = 0;
  std::optional<double> last_turned_;  // by the compass, and the filter's yaw then
  double last_yaw_ = 0;
  bool seen_ = false;
};

}  // namespace

std::unique_ptr<Mission> MakeMission(const AttitudeFlight& flight, const CameraModel& camera,
                                     const Pose& X_BC, const cv::Mat& forbidden, std::uint64_t seed) {
  return std::make_unique<AttitudeMission>(flight, camera, X_BC, forbidden, seed);
}

}  // namespace kestrel
