// SPDX-License-Identifier: Apache-2.0
#include "scenarios/helipad_pilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "geometry/tait_bryan.h"
#include "vision/homography.h"

namespace kestrel {
namespace {

constexpr double kWaypointReached_m = 1.0;
constexpr double kLegOverlap = 0.7;  // of the field of view, between neighbouring legs of the search

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int y = 0; y < a.rows; ++y)
    if (std::memcmp(a.ptr(y), b.ptr(y), a.cols * a.elemSize()) != 0) return false;
  return true;
}

}  // namespace

HelipadPilot::HelipadPilot(PadReference reference, const Pinhole& camera, const Pose& X_BC,
                           const PilotParameters& parameters)
    : parameters_(parameters),
      camera_(camera),
      tracker_(std::move(reference), camera, parameters.tracker),
      estimator_(X_BC, parameters.estimator) {}

Decision HelipadPilot::See(const Frame& frame, const VehicleState& state) {
  const auto start = std::chrono::steady_clock::now();
  Decision decision;
  cv::Mat grey = frame.image;
  if (grey.channels() == 3) cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
  estimator_.Hear(state);
  latency_s_ = state.t_s - frame.t_s;
  // Noise never repeats itself: the same image again is an old one under a new time, and to follow it would
  // be to fly blind without knowing.
  const bool frozen = SamePixels(grey, last_image_);
  grey.copyTo(last_image_);
  seen_ = frozen ? std::nullopt : tracker_.Track(grey, estimator_.ExpectedPose(frame.t_s));
  fix_.reset();
  if (seen_) {
    if (const auto X_TB = estimator_.Correct(frame.t_s, seen_->X_CT, seen_->covariance)) {
      fix_ = TargetFix{X_TB->p,        YawOf(X_TB->R),   seen_->inliers, seen_->residual_px,
                       seen_->visible, seen_->registered};
    }
  }
  estimate_ = estimator_.At(state.t_s);
  decision.fix = fix_;
  decision.fix_age_s = estimate_ ? estimate_->age_s : state.t_s;
  decision.target = frozen              ? "frozen"
                    : !seen_            ? "lost"
                    : !fix_             ? "refused"
                    : seen_->found      ? "found"
                    : seen_->registered ? "tracked"
                                        : "chained";
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

VelocitySetpoint HelipadPilot::GoTo(const Eigen::Vector3d& p_T, double yaw_T) const {
  const Pose X_TH{HeadingRotation(estimate_->yaw_TB), estimate_->p_TB};
  const Pose X_TD{HeadingRotation(yaw_T), p_T};
  VelocitySetpoint setpoint = ServoSetpoint(X_TD.Inverse() * X_TH, parameters_.servo);
  // The autopilot flies the velocity that it believes in: ask for what is wanted plus its error.
  setpoint.v_H += X_TH.R.conjugate() * estimate_->velocity_error_T;
  return setpoint;
}

VelocitySetpoint HelipadPilot::DescendTo(const Eigen::Vector2d& p_T, double yaw_T, double sink_m_s) const {
  VelocitySetpoint setpoint = GoTo({p_T.x(), p_T.y(), estimate_->p_TB.z()}, yaw_T);
  setpoint.v_H.z() += sink_m_s;
  return setpoint;
}

std::optional<Setpoint> HelipadPilot::Search(const VehicleState& state) {
  const SearchParameters& search = parameters_.search;
  if (!lost_since_s_) lost_since_s_ = state.t_s;
  const double lost_s = state.t_s - *lost_since_s_;
  if (lost_s > search.give_up_s) return std::nullopt;
  if (lost_s < search.stop_s) return VelocitySetpoint{};
  if (-state.p_NB.z() < search.ceiling_m && leg_ < 0) return VelocitySetpoint{{0, 0, -search.climb_m_s}, 0};
  return GrowingSquare(state);
}

// Legs north, east, south, west, each pair one stride longer, about where the pad was last seen or the search
// began.
Setpoint HelipadPilot::GrowingSquare(const VehicleState& state) {
  const bool reached = (state.p_NB - waypoint_.p_N).norm() < kWaypointReached_m;
  if (leg_ < 0) {
    leg_ = 0;
    waypoint_ = {{last_place_N_.x(), last_place_N_.y(), state.p_NB.z()}, YawOf(state.R_NB)};
    if (!placed_) waypoint_.p_N = state.p_NB;
  } else if (reached) {
    const double view_m =
        -state.p_NB.z() * std::min(camera_.width_px / camera_.fx, camera_.height_px / camera_.fy);
    const double length = kLegOverlap * view_m * (1 + leg_ / 2);
    const int direction = leg_++ % 4;
    waypoint_.p_N.x() += direction == 0 ? length : direction == 2 ? -length : 0;
    waypoint_.p_N.y() += direction == 1 ? length : direction == 3 ? -length : 0;
  }
  return waypoint_;
}

void HelipadPilot::Draw(cv::Mat& bgr, std::string_view phase) const {
  const cv::Scalar kTracked(0, 200, 255), kInlier(80, 255, 80), kOutline(255, 220, 0), kText(255, 255, 255);
  const auto point = [](const Eigen::Vector2d& p) { return cv::Point2d(p.x(), p.y()); };
  for (const auto& p : tracker_.tracked_points()) cv::circle(bgr, point(p), 2, kTracked, 1, cv::LINE_AA);
  if (seen_) {
    for (const auto& p : tracker_.inlier_points()) cv::circle(bgr, point(p), 3, kInlier, 1, cv::LINE_AA);
    std::vector<cv::Point> outline;
    for (const auto& corner : tracker_.reference().Outline())
      outline.push_back(point(Transfer(seen_->H_w, corner)));
    cv::polylines(bgr, outline, true, kOutline, 2, cv::LINE_AA);
    const auto origin = camera_.Project(seen_->X_CT.p);
    const cv::Scalar colours[3] = {{60, 60, 255}, {60, 220, 60}, {255, 120, 60}};
    for (int axis = 0; axis < 3; ++axis) {
      // z is drawn upwards: down into the ground it would hide behind the pad
      const Eigen::Vector3d tip = (axis == 2 ? -0.35 : 0.35) * Eigen::Vector3d::Unit(axis);
      const auto end = camera_.Project(seen_->X_CT * tip);
      if (origin && end)
        cv::arrowedLine(bgr, point(*origin), point(*end), colours[axis], 2, cv::LINE_AA, 0, 0.12);
    }
  }
  const auto line = [&](int row, const std::string& text) {
    const cv::Point at(8, 20 + 18 * row);
    cv::putText(bgr, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.48, {0, 0, 0}, 3, cv::LINE_AA);
    cv::putText(bgr, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.48, kText, 1, cv::LINE_AA);
  };
  line(0, fmt::format("{}{}", phase, fix_ ? "" : "   pad lost"));
  if (fix_) {
    line(1, fmt::format("x {:+.2f}  y {:+.2f}  z {:+.2f} m   yaw {:+.1f} deg", fix_->p_TB.x(), fix_->p_TB.y(),
                        fix_->p_TB.z(), Degrees(fix_->yaw_TB)));
    line(2, fmt::format("{} inliers  {:.2f} px  {:.0f} % of the pad", fix_->inliers, fix_->residual_px,
                        100 * std::min(1.0, fix_->visible)));
  } else if (estimate_) {
    line(1, fmt::format("last seen {:.1f} s ago", estimate_->age_s));
  }
}

}  // namespace kestrel
