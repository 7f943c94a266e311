// SPDX-License-Identifier: Apache-2.0
#include "mission/ground/ground_observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "geometry/tait_bryan.h"
#include "mission/caption/strip.h"
#include "vision/drawn_colours.h"

namespace kestrel::mission {
namespace {

constexpr double kFuture_s = 0.02;  // of a stamp
constexpr double kOldest_s = 1.5;   // a frame when it comes
constexpr double kAround_m = 0.8;   // of where the aircraft is expected, that is looked at
constexpr int kMissesToFind = 3;    // in a row, until the whole image is looked at
constexpr double kYawSigma_deg = 8;
// The head sweeps when the aircraft has been lost for so long: half widths and periods.
constexpr double kSweepAfter_s = 2, kSweepPan_deg = 35, kSweepPan_s = 9, kSweepTilt_deg = 12,
                 kSweepTilt_s = 3.7;

bool Within(const Eigen::Vector2d& uv, const vision::CameraModel& camera, double margin_px) {
  return uv.x() > margin_px && uv.y() > margin_px && uv.x() < vision::WidthPx(camera) - 1 - margin_px &&
         uv.y() < vision::HeightPx(camera) - 1 - margin_px;
}

}  // namespace

const char* NameOf(GroundState state) {
  constexpr const char* kNames[] = {"no frame", "found", "tracked", "lost", "out of view", "frozen", "clock"};
  return kNames[static_cast<int>(state)];
}

GroundObserver::GroundObserver(const vision::GroundSight& sight)
    : sight_(sight), X_TG_(vision::MastPose(sight.place)) {}

std::vector<GroundFix> GroundObserver::Observe(const control::StateHistory& states, double now_s,
                                               const std::function<std::optional<Pose>(double)>& expected) {
  std::vector<GroundFix> fixes;
  while (auto taken = sight_.stream ? sight_.stream->Take() : std::nullopt) {
    const double t_s = taken->frame.t_s;
    frame_s_ = t_s;
    image_ = taken->frame.image;
    spots_.clear();
    X_CB_.reset();
    const auto state = states.At(t_s);
    if (t_s > now_s + kFuture_s || t_s < now_s - kOldest_s || !state) {
      state_ = GroundState::kClock;
      continue;
    }
    if (frozen_.Is(image_)) {
      state_ = GroundState::kFrozen;
      continue;
    }
    const std::optional<Pose> X_TB = expected(t_s);
    if (const auto fix = Look(*taken, state->R_NB, X_TB)) fixes.push_back(*fix);
  }
  TurnHead(now_s, !fixes.empty() ? std::optional(fixes.back().X_TB) : expected(now_s));
  return fixes;
}

cv::Rect GroundObserver::Part(const Eigen::Vector2d& uv, double range_m) const {
  const int half = static_cast<int>(
      std::ceil(20 + kAround_m * vision::Parameters(sight_.camera)[0] / std::max(range_m, 0.5)));
  return {static_cast<int>(uv.x()) - half, static_cast<int>(uv.y()) - half, 2 * half, 2 * half};
}

std::optional<GroundFix> GroundObserver::Look(const vision::GroundFrame& taken,
                                              const Eigen::Quaterniond& R_NB,
                                              const std::optional<Pose>& X_TB) {
  const Pose X_TC = vision::CameraPose(X_TG_, taken.at);
  const Eigen::Vector3d down_C = X_TC.R.conjugate() * Eigen::Vector3d::UnitZ();
  vision::ExpectedAircraft expected;
  cv::Rect part({}, image_.size());
  bool beyond = false, in_part = false;
  if (X_TB) {
    const Pose X_CB = X_TC.Inverse() * *X_TB;
    const auto uv = vision::Project(sight_.camera, X_CB.p);
    beyond = !uv || !Within(*uv, sight_.camera, 0);
    in_part = !beyond && misses_ < kMissesToFind;
    if (in_part) {
      part = Part(*uv, X_CB.p.norm());
      expected = {.R_CB = X_CB.R,
                  .yaw_sigma = Radians(std::hypot(kYawSigma_deg, sight_.place.angle_sigma_deg)),
                  .p_CB = X_CB.p};
    }
  }
  // Of an attitude without its turn about the vertical all turns are tried.
  if (!in_part) expected.R_CB = X_TC.R.conjugate() * (HeadingRotation(-YawOf(R_NB)) * R_NB);
  cv::Mat colour = image_;
  if (colour.channels() == 1) cv::cvtColor(image_, colour, cv::COLOR_GRAY2BGR);
  spots_ = vision::FindLights(colour, part, {sight_.lights.colour_1, sight_.lights.colour_2});
  vision::LightPoseOptions options;
  options.tilt_sigma_deg = std::hypot(options.tilt_sigma_deg, sight_.place.angle_sigma_deg);
  const auto pose = vision::PoseFromLights(spots_, sight_.lights, sight_.camera, expected, down_C, options);
  if (!pose) {
    misses_ = std::min(misses_ + 1, kMissesToFind);
    state_ = beyond ? GroundState::kOutOfView : GroundState::kLost;
    return std::nullopt;
  }
  misses_ = 0;
  state_ = in_part ? GroundState::kTracked : GroundState::kFound;
  X_CB_ = pose->X_CB;
  const Eigen::Matrix3d R_TC = X_TC.R.toRotationMatrix();
  return GroundFix{taken.frame.t_s, X_TC * pose->X_CB,
                   R_TC * pose->covariance.topLeftCorner<3, 3>() * R_TC.transpose(), pose->lights,
                   pose->residual_px};
}

void GroundObserver::TurnHead(double now_s, const std::optional<Pose>& X_TB) {
  if (!sight_.stream) return;
  if (X_TB) {
    head_ = vision::LookAt(X_TG_, X_TB->p, head_);
    lost_since_s_.reset();
    return sight_.stream->Turn(head_);
  }
  if (!lost_since_s_) lost_since_s_ = now_s;
  const double lost_s = now_s - *lost_since_s_ - kSweepAfter_s;
  if (lost_s < 0) return;
  const auto swing = [&](double half_deg, double period_s) {
    return Radians(half_deg) * std::sin(2 * std::numbers::pi * lost_s / period_s);
  };
  sight_.stream->Turn(
      {head_.pan + swing(kSweepPan_deg, kSweepPan_s), head_.tilt + swing(kSweepTilt_deg, kSweepTilt_s)});
}

cv::Mat GroundObserver::Drawn() const {
  if (image_.empty()) return {};
  cv::Mat bgr;
  if (image_.channels() == 1)
    cv::cvtColor(image_, bgr, cv::COLOR_GRAY2BGR);
  else
    bgr = image_.clone();
  const auto at = [](const Eigen::Vector2d& uv) {
    return cv::Point(static_cast<int>(std::lround(uv.x())), static_cast<int>(std::lround(uv.y())));
  };
  for (const vision::LightSpot& spot : spots_) cv::circle(bgr, at(spot.centre), 7, vision::kFixColour, 1);
  if (X_CB_) {
    constexpr double kAxis_m = 0.35;
    const auto origin = vision::Project(sight_.camera, X_CB_->p);
    const cv::Scalar colours[] = {{60, 60, 255}, {80, 255, 80}, {255, 120, 60}};
    for (int i = 0; i < 3; ++i) {
      const auto end = vision::Project(sight_.camera, *X_CB_ * (kAxis_m * Eigen::Vector3d::Unit(i)));
      if (origin && end) cv::line(bgr, at(*origin), at(*end), colours[i], 2, cv::LINE_AA);
    }
    for (const vision::AircraftLight& light : sight_.lights.lights)
      if (const auto uv = vision::Project(sight_.camera, *X_CB_ * light.position_m))
        cv::drawMarker(bgr, at(*uv), {255, 255, 255}, cv::MARKER_CROSS, 5, 1);
  }
  return WithStrip(bgr, {fmt::format("camera on the ground: {}", NameOf(state_)), {}, {}}, 1);
}

}  // namespace kestrel::mission
