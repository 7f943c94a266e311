// SPDX-License-Identifier: Apache-2.0
#include "scenarios/gyro_failure/gyro_failure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string_view>

#include "geometry/tait_bryan.h"
#include "mission/caption/caption.h"
#include "mission/horizon_observer.h"
#include "mission/horizon_records.h"
#include "records/plot/horizon_plot.h"
#include "vision/drawn_colours.h"
#include "vision/horizon/horizon_drawing.h"

namespace kestrel::scenarios {
namespace {

constexpr int kFrames = 3;             // in a row that must say the same before anything is believed
constexpr double kLearnTime_s = 5;     // over which what is usual between both attitudes is learnt
constexpr double kUsual = Radians(3);  // the most that it may be: an accelerometer's bias is 1 or 2 degrees
constexpr double kSoundSigma = Radians(1), kFresh_s = 0.5;  // of a camera's attitude that may accuse

class GyroFailureMission final : public mission::Mission {
 public:
  GyroFailureMission(const GyroFailureFlight& flight, const vision::CameraModel& camera, const Pose& X_BC,
                     const cv::Mat& forbidden)
      : flight_(flight), watch_(camera, X_BC, forbidden) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    decision.report = std::make_shared<mission::HorizonReport>(watch_.Observe(frame, state, decision));
    if (!home_) home_ = control::PositionSetpoint{state.p_NB, YawOf(state.R_NB)};
    decision.setpoint = home_;
    const auto seen = watch_.Now();
    const std::string_view fault = FaultOf(state, seen);
    if (!fault.empty()) fault_ = fault;
    if (by_own_ && !fault.empty()) by_own_ = false, trial_.reset();
    if (by_own_) {
      decision.phase = "by own attitude";
      if (seen) LearnWhatIsUsual(state, *seen);
    } else {
      FlyBySight(state, seen, decision);
      MayReturn(state, seen, fault);
    }
    phase_ = decision.phase;
    last_inertial_ = state.R_NB_inertial;
    last_s_ = state.t_s;
    return decision;
  }
  bool Accomplished() const override { return watch_.seen(); }
  // The autopilot holds the place; without a skyline for too long it is no longer aided, and flies by its
  // own.
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }
  void Draw(cv::Mat& bgr) const override {
    watch_.Draw(bgr);
    DrawOwn(bgr);
  }
  std::vector<mission::Caption> Captions() const override {
    std::vector<mission::Caption> captions = watch_.Captions(phase_);
    captions.front().alarm = !by_own_;
    return captions;
  }

 private:
  using Estimate = control::HorizonFilter::Estimate;

  // The camera's attitude, about the autopilot's north.
  Eigen::Quaterniond Sighted(const Estimate& seen) const {
    return HeadingRotation(usual_->north) * seen.R_NB;
  }

  // The autopilot's own attitude in the corner across from the camera's, struck out where it is not believed.
  void DrawOwn(cv::Mat& bgr) const {
    constexpr int kRadius_px = vision::kHorizonRadius_px, kMiddle_px = vision::kHorizonMiddle_px;
    if (bgr.cols < 4 * kMiddle_px) return;
    const cv::Point centre(bgr.cols - kMiddle_px, kMiddle_px);
    if (last_inertial_) {
      const TaitBryan own = TaitBryanFromRotation(last_inertial_->toRotationMatrix());
      vision::DrawArtificialHorizon(bgr, centre, kRadius_px, {own.roll, own.pitch}, vision::kEstimateColour);
    }
    mission::NameMark(bgr, {8, 2 * kMiddle_px + 8}, "by sight");
    mission::NameMark(bgr, {bgr.cols - 112, 2 * kMiddle_px + 8}, by_own_ ? "own attitude" : "own: FAILED");
    if (by_own_) return;
    const cv::Point across(37, 37), down(37, -37);
    cv::circle(bgr, centre, kRadius_px - 1, vision::kLimitColour, 3, cv::LINE_AA);
    cv::line(bgr, centre - across, centre + across, vision::kLimitColour, 4, cv::LINE_AA);
    cv::line(bgr, centre - down, centre + down, vision::kLimitColour, 4, cv::LINE_AA);
  }

  // What is wrong with the autopilot's own attitude; empty: nothing.
  std::string_view FaultOf(const control::VehicleState& state, const std::optional<Estimate>& seen) {
    const auto& own = state.R_NB_inertial;
    still_ = own && last_inertial_ && own->coeffs() == last_inertial_->coeffs() ? still_ + 1 : 0;
    const bool sound = seen && usual_ && seen->coasting_s < kFresh_s &&
                       std::sqrt(seen->P.topLeftCorner<3, 3>().trace()) < kSoundSigma;
    apart_ = std::numeric_limits<double>::infinity();
    if (own && sound) apart_ = (Sighted(*seen) * ExpRotation(usual_->tilt_B)).angularDistance(*own);
    apart_frames_ = own && sound && apart_ > Radians(flight_.disagree_deg) ? apart_frames_ + 1 : 0;
    if (!own) return "by sight: own attitude silent";
    if (still_ >= kFrames) return "by sight: own attitude frozen";
    if (apart_frames_ >= kFrames) return "by sight: own attitude wrong";
    return {};
  }

  // The camera knows how far the aircraft has turned, but not from where, and the autopilot's level is off by
  // a degree or two for as long as it flies.
  void LearnWhatIsUsual(const control::VehicleState& state, const Estimate& seen) {
    if (apart_frames_ > 0) return;
    const Eigen::Quaterniond& own = *state.R_NB_inertial;
    const double north = YawOf(own) - YawOf(seen.R_NB);
    const auto tilt_B = [&] { return LogRotation(Sighted(seen).conjugate() * own); };
    if (!usual_) {
      usual_.emplace().north = north;
      usual_->tilt_B = tilt_B();
    }
    const double share = 1 - std::exp(-(state.t_s - last_s_) / kLearnTime_s);
    usual_->north = WrapAngle(usual_->north + share * WrapAngle(north - usual_->north));
    usual_->tilt_B += share * (tilt_B() - usual_->tilt_B);
    usual_->tilt_B *= std::min(1.0, kUsual / std::max(usual_->tilt_B.norm(), 1e-9));
  }

  void FlyBySight(const control::VehicleState& state, const std::optional<Estimate>& seen,
                  mission::Decision& decision) {
    if (!seen || seen->coasting_s > flight_.coast_s) {
      decision.phase = "blind";
      return;
    }
    if (!usual_) usual_.emplace().north = YawOf(state.R_NB) - YawOf(seen->R_NB);  // the last that was heard
    const bool on_trial = apart_ < Radians(flight_.disagree_deg) && still_ < kFrames;
    decision.phase = on_trial ? "by sight: own attitude on trial" : fault_;
    decision.aid = control::AttitudeAid{Sighted(*seen), std::sqrt(seen->P.topLeftCorner<3, 3>().trace() / 3)};
  }

  // It may come back with another level than it had: its sensors have drifted on meanwhile. What counts is
  // that it is not far off and keeps its distance; that is what is usual from then on.
  void MayReturn(const control::VehicleState& state, const std::optional<Estimate>& seen,
                 std::string_view fault) {
    if (!fault.empty() || apart_ > Radians(flight_.disagree_deg)) {
      trial_.reset();
      return;
    }
    const Eigen::Vector3d apart_B = LogRotation(Sighted(*seen).conjugate() * *state.R_NB_inertial);
    if (!trial_ || (apart_B - trial_->apart_B).norm() > Radians(flight_.agree_deg))
      trial_ = Trial{state.t_s, apart_B};
    if (state.t_s - trial_->since_s > flight_.agree_s) by_own_ = true, usual_.reset();
  }

  GyroFailureFlight flight_;
  mission::HorizonObserver watch_;
  std::optional<control::PositionSetpoint> home_;
  struct Usual {                                       // between both attitudes
    double north = 0;                                  // yaw of the autopilot's less yaw of the camera's, rad
    Eigen::Vector3d tilt_B = Eigen::Vector3d::Zero();  // the rest as a rotation vector, rad
  };
  std::optional<Usual> usual_;
  std::optional<Eigen::Quaterniond> last_inertial_;
  double last_s_ = 0;
  int still_ = 0, apart_frames_ = 0;
  double apart_ = 0;  // rad, between both attitudes beyond the usual; infinite: they cannot be compared
  bool by_own_ = true;
  std::string_view fault_;  // the last that was found
  std::string_view phase_;
  struct Trial {
    double since_s;
    Eigen::Vector3d apart_B;  // both attitudes then, as a rotation vector
  };
  std::optional<Trial> trial_;
};

}  // namespace

mission::MissionType TypeOf(const GyroFailureFlight&) {
  return {.name = "gyro_failure",
          .summary = "Holds its place by the attitude from the skyline while the autopilot's own has failed.",
          .telemetry = mission::HorizonColumns(),
          .metrics = mission::HorizonMetrics(),
          .add_metrics = mission::AddHorizonMetrics,
          .plots = {{"attitude.png", records::MeasuresAttitude, records::HorizonPlot}}};
}

bool FlightCanHave(const GyroFailureFlight&, const std::string& metric, const mission::Varies&) {
  return !metric.starts_with("baseline_");
}

std::unique_ptr<mission::Mission> MakeMission(const GyroFailureFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<GyroFailureMission>(flight, parts.camera, parts.X_BC, parts.own_parts);
}

}  // namespace kestrel::scenarios
