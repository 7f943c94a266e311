// SPDX-License-Identifier: Apache-2.0
#include "mission/helipad_pilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "base/stopwatch.h"
#include "geometry/tait_bryan.h"
#include "vision/drawn_colours.h"
#include "vision/landmark/pad_drawing.h"

namespace kestrel::mission {
namespace {

constexpr double kWaypointReached_m = 1.0;
constexpr double kLegOverlap = 0.7;  // of the field of view, between neighbouring legs of the search

constexpr double kMaxField_deg = 100;  // of the virtual camera: about as many pixels as a fisheye has

}  // namespace

std::optional<vision::Pinhole> TrackersCamera(const vision::CameraModel& camera) {
  if (const auto* pinhole = std::get_if<vision::Pinhole>(&camera)) return *pinhole;
  return vision::CentralPinhole(camera, Radians(kMaxField_deg));
}

TargetFix FixBy(const vision::PadObservation& seen, const Pose& X_TB) {
  return {X_TB.p, YawOf(X_TB.R), seen.inliers, seen.residual_px, seen.visible, seen.registered};
}

void TellPad(bool frozen, const std::optional<vision::PadObservation>& seen,
             const std::optional<TargetFix>& fix, Decision& decision) {
  decision.target = frozen             ? "frozen"
                    : !seen            ? "lost"
                    : !fix             ? "refused"
                    : seen->found      ? "found"
                    : seen->registered ? "tracked"
                                       : "chained";
  decision.target_state = frozen  ? TargetState::kBlind
                          : !seen ? TargetState::kLost
                          : !fix  ? TargetState::kUncertain
                                  : TargetState::kInSight;
}

HelipadPilot::HelipadPilot(vision::PadReference reference, const vision::CameraModel& camera,
                           const Pose& X_BC, const PilotParameters& parameters)
    : Pilot(parameters.servo),
      parameters_(parameters),
      camera_(camera),
      view_(TrackersCamera(camera).value()),
      tracker_(std::move(reference), view_, parameters.tracker),
      estimator_(X_BC, parameters.estimator) {
  if (!std::holds_alternative<vision::Pinhole>(camera))
    to_view_ = vision::MakeViewTable(vision::PerspectiveView{view_}, camera);
}

Decision HelipadPilot::Observe(const vision::Frame& frame, const control::VehicleState& state) {
  const auto start = std::chrono::steady_clock::now();
  Decision decision;
  cv::Mat grey = frame.image;
  if (grey.channels() == 3) cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
  if (to_view_) grey = vision::Look(*to_view_, grey);
  Hear(state);
  estimator_.AddState(state);
  latency_s_ = state.t_s - frame.t_s;
  const bool frozen = frozen_.Is(grey);
  seen_ = frozen ? std::nullopt : tracker_.Track(grey, estimator_.ExpectedPose(frame.t_s));
  fix_.reset();
  if (seen_) {
    if (const auto X_TB = estimator_.Correct(frame.t_s, seen_->X_CT, seen_->covariance)) {
      fix_ = FixBy(*seen_, *X_TB);
    }
  }
  estimate_ = estimator_.At(state.t_s);
  decision.fix = fix_;
  decision.fix_age_s = estimate_ ? estimate_->age_s : state.t_s;
  TellPad(frozen, seen_, fix_, decision);
  if (fix_) {
    lost_since_s_.reset();
    leg_ = -1;
    const Eigen::Quaterniond R_NT = HeadingRotation(YawOf(state.R_NB) - estimate_->yaw_TB);
    last_place_N_ = state.p_NB - R_NT * estimate_->p_TB;
    placed_ = true;
  }
  decision.vision_s = SecondsSince(start);
  return decision;
}

std::optional<control::Setpoint> HelipadPilot::Search(const control::VehicleState& state) {
  const SearchParameters& search = parameters_.search;
  if (!lost_since_s_) lost_since_s_ = state.t_s;
  const double lost_s = state.t_s - *lost_since_s_;
  if (lost_s > search.give_up_s) return std::nullopt;
  if (lost_s < search.stop_s) return control::VelocitySetpoint{};
  if (-state.p_NB.z() < search.ceiling_m && leg_ < 0)
    return control::VelocitySetpoint{{0, 0, -search.climb_m_s}, 0};
  return GrowingSquare(state);
}

// Legs north, east, south, west, each pair one stride longer, about where the pad was last seen or the search
// began.
control::Setpoint HelipadPilot::GrowingSquare(const control::VehicleState& state) {
  const bool reached = (state.p_NB - waypoint_.p_N).norm() < kWaypointReached_m;
  if (leg_ < 0) {
    leg_ = 0;
    waypoint_ = {{last_place_N_.x(), last_place_N_.y(), state.p_NB.z()}, YawOf(state.R_NB)};
    if (!placed_) waypoint_.p_N = state.p_NB;
  } else if (reached) {
    const double view_m = -state.p_NB.z() * std::min(view_.width_px / view_.fx, view_.height_px / view_.fy);
    const double length = kLegOverlap * view_m * (1 + leg_ / 2);
    const int direction = leg_++ % 4;
    waypoint_.p_N.x() += direction == 0 ? length : direction == 2 ? -length : 0;
    waypoint_.p_N.y() += direction == 1 ? length : direction == 3 ? -length : 0;
  }
  return waypoint_;
}

void HelipadPilot::Draw(cv::Mat& bgr) const {
  vision::DrawPoints(bgr, camera_, view_, tracker_.tracked_points(), 2, vision::kPointColour);
  if (!seen_) return;
  vision::DrawPoints(bgr, camera_, view_, tracker_.inlier_points(), 3, vision::kFixColour);
  vision::DrawOutlineAndAxes(bgr, camera_, seen_->X_CT, tracker_.reference().Outline());
}

std::vector<Caption> HelipadPilot::Captions(std::string_view phase) const {
  std::vector<Caption> captions = {{std::string(phase)}};
  if (!fix_) captions.push_back({"pad lost", true});
  if (fix_) {
    captions.push_back({fmt::format("x {:+.2f}  y {:+.2f}  z {:+.2f} m  yaw {:+.1f} deg", fix_->p_TB.x(),
                                    fix_->p_TB.y(), fix_->p_TB.z(), Degrees(fix_->yaw_TB))});
    captions.push_back({fmt::format("{} inliers, {:.2f} px, over {:.0f} % of the pad", fix_->inliers,
                                    fix_->residual_px, 100 * std::min(1.0, fix_->visible))});
  } else if (estimate_) {
    captions.push_back({fmt::format("last seen {:.1f} s ago", estimate_->age_s)});
  }
  if (following().level_s() > 0 || following().climb_s() > 0)
    captions.push_back({fmt::format("autopilot late by {:.1f} s sideways, {:.1f} s up and down",
                                    following().level_s(), following().climb_s())});
  return captions;
}

}  // namespace kestrel::mission
