// SPDX-License-Identifier: Apache-2.0
#include "scenarios/gyro_failure/gyro_failure.h"

#include <cmath>
#include <optional>
#include <string_view>

#include "geometry/tait_bryan.h"
#include "scenarios/attitude/horizon_watch.h"

namespace kestrel {
namespace {

constexpr int kFrames = 3;            // in a row that must say the same before anything is believed
constexpr double kHeadingTime_s = 5;  // over which the camera's heading is matched to the autopilot's
constexpr double kSoundSigma = Radians(1), kFresh_s = 0.5;  // of a camera's attitude that may accuse

class GyroFailureMission final : public Mission {
 public:
  GyroFailureMission(const GyroFailureFlight& flight, const CameraModel& camera, const Pose& X_BC,
                     const cv::Mat& forbidden)
      : flight_(flight), watch_(camera, X_BC, forbidden) {}

  Decision Step(const Frame& frame, const VehicleState& state) override {
    Decision decision;
    watch_.See(frame, state, decision);
    if (!home_) home_ = PositionSetpoint{state.p_NB, YawOf(state.R_NB)};
    decision.setpoint = home_;
    const auto seen = watch_.Now();
    const std::string_view fault = FaultOf(state, seen);
    if (!by_vision_) {
      decision.phase = "by own attitude";
      if (!fault.empty() && north_ && seen) by_vision_ = true, agreed_since_s_.reset();
      if (fault.empty() && seen) LearnNorth(state, *seen);
    }
    if (by_vision_) {
      FlyBySight(state, *seen, fault, decision);
      MayReturn(state, fault);
    }
    last_inertial_ = state.R_NB_inertial;
    last_s_ = state.t_s;
    return decision;
  }
  bool Accomplished() const override { return watch_.seen(); }
  void Draw(cv::Mat& bgr) const override { watch_.Draw(bgr); }

 private:
  using Estimate = HorizonFilter::Estimate;

  Eigen::Quaterniond Sighted(const Estimate& seen) const { return HeadingRotation(*north_) * seen.R_NB; }

  // What is wrong with the autopilot's own attitude; empty: nothing.
  std::string_view FaultOf(const VehicleState& state, const std::optional<Estimate>& seen) {
    const auto& own = state.R_NB_inertial;
    still_ = own && last_inertial_ && own->coeffs() == last_inertial_->coeffs() ? still_ + 1 : 0;
    const bool sound = seen && north_ && seen->coasting_s < kFresh_s &&
                       std::sqrt(seen->P.topLeftCorner<3, 3>().trace()) < kSoundSigma;
    if (own && sound) apart_ = Sighted(*seen).angularDistance(*own);
    apart_frames_ = own && sound && apart_ > Radians(flight_.disagree_deg) ? apart_frames_ + 1 : 0;
    if (!own) return "by sight: own attitude silent";
    if (still_ >= kFrames) return "by sight: own attitude frozen";
    if (apart_frames_ >= kFrames) return "by sight: own attitude wrong";
    return {};
  }

  // The camera knows how far it has turned; what north is it learns while all is well.
  void LearnNorth(const VehicleState& state, const Estimate& seen) {
    const double now = YawOf(*state.R_NB_inertial) - YawOf(seen.R_NB);
    if (!north_) north_ = now;
    if (apart_frames_ > 0) return;
    const double share = 1 - std::exp(-(state.t_s - last_s_) / kHeadingTime_s);
    north_ = WrapAngle(*north_ + share * WrapAngle(now - *north_));
  }

  void FlyBySight(const VehicleState&, const Estimate& seen, std::string_view fault, Decision& decision) {
    decision.phase = fault.empty() ? "by sight: own attitude on trial" : fault;
    if (seen.coasting_s > flight_.coast_s) {
      decision.phase = "blind";
      return;
    }
    decision.aid = AttitudeAid{Sighted(seen), std::sqrt(seen.P.topLeftCorner<3, 3>().trace() / 3)};
  }

  void MayReturn(const VehicleState& state, std::string_view fault) {
    if (!fault.empty() || apart_ > Radians(flight_.agree_deg)) {
      agreed_since_s_.reset();
      return;
    }
    if (!agreed_since_s_) agreed_since_s_ = state.t_s;
    if (state.t_s - *agreed_since_s_ > flight_.agree_s) by_vision_ = false;
  }

  GyroFailureFlight flight_;
  HorizonWatch watch_;
  std::optional<PositionSetpoint> home_;
  std::optional<double> north_;  // yaw of the autopilot's less yaw of the camera's, rad
  std::optional<Eigen::Quaterniond> last_inertial_;
  double last_s_ = 0;
  int still_ = 0, apart_frames_ = 0;
  double apart_ = 0;  // rad, between both attitudes, when they were last compared
  bool by_vision_ = false;
  std::optional<double> agreed_since_s_;
};

}  // namespace

std::unique_ptr<Mission> MakeMission(const GyroFailureFlight& flight, const CameraModel& camera,
                                     const Pose& X_BC, const cv::Mat& forbidden, std::uint64_t) {
  return std::make_unique<GyroFailureMission>(flight, camera, X_BC, forbidden);
}

}  // namespace kestrel
