// SPDX-License-Identifier: Apache-2.0
#include "mission/balloon_observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/diagnostics.h"
#include "vision/drawn_colours.h"

namespace kestrel::mission {
namespace {

constexpr double kSure_s = 0.5;  // after so long it may be elsewhere than where it went
constexpr double kForget_s = 3;  // what was seen so long ago says nothing of how it moves now

}  // namespace

BalloonObserver::BalloonObserver(const vision::CameraModel& camera, const Pose& X_BC,
                                 const BalloonObserverParameters& parameters, vision::BalloonMeasure measure)
    : parameters_(parameters),
      camera_(camera),
      tracker_(vision::ColourModel(parameters.colour), camera, parameters.tracker, measure),
      target_(X_BC, parameters.estimator) {}

void BalloonObserver::Observe(const vision::Frame& frame, const control::VehicleState& state, bool frozen) {
  target_.AddState(state);
  seen_.reset();
  if (!frozen) {
    std::optional<vision::OutlineCone> expected;
    if (const auto p_CT = target_.InCamera(frame.t_s, kSure_s))
      expected = vision::ConeOfSphere(*p_CT, parameters_.diameter_m / 2);
    seen_ = tracker_.Track(frame.image, expected);
  }
  if (Measured()) {
    const vision::OutlineCone& cone = *seen_->cone;
    const double radius = parameters_.diameter_m / 2;
    const double distance = radius / std::sin(cone.half_angle);
    const double along = distance / std::tan(cone.half_angle);  // m per rad of the half-angle
    Eigen::Matrix<double, 3, 4> J;
    J << distance * Eigen::Matrix3d::Identity(), -along * cone.axis;
    if (target_.At(state.t_s) && target_.At(state.t_s)->age_s > kForget_s) target_.Forget();
    target_.Correct(frame.t_s, distance * cone.axis, J * seen_->covariance * J.transpose());
  }
  estimate_ = target_.At(state.t_s);
  age_s_ = estimate_ ? estimate_->age_s : state.t_s;
}

bool BalloonObserver::Sees() const {
  return seen_ && seen_->track.state != vision::TrackState::kMatchesTooMuch &&
         seen_->track.state != vision::TrackState::kBadImage;
}

std::string_view BalloonObserver::status() const {
  if (!seen_) return "frozen";
  if (!seen_->cone && seen_->track.state == vision::TrackState::kTracked) return "not round";
  return vision::NameOf(seen_->track.state);
}

void BalloonObserver::Draw(cv::Mat& bgr) const {
  if (!Measured()) return;
  std::vector<cv::Point> outline;
  for (const Eigen::Vector2d& p : vision::DrawOutline(camera_, *seen_->cone, 90))
    outline.emplace_back(static_cast<int>(std::lround(16 * p.x())),
                         static_cast<int>(std::lround(16 * p.y())));
  cv::polylines(bgr, outline, true, vision::kFixColour, 2, cv::LINE_AA, 4);
}

TargetState BalloonObserver::target_state() const {
  if (!Sees()) return TargetState::kBlind;
  switch (state()) {
    case vision::TrackState::kTracked:
      return Measured() ? TargetState::kInSight : TargetState::kUncertain;
    case vision::TrackState::kLost:
    case vision::TrackState::kSearching:
      return TargetState::kLost;
    default:
      return TargetState::kUncertain;
  }
}

void CheckColour(const vision::ColourRange& colour, const std::string& key, const Place& where,
                 Mistakes& mistakes) {
  if (colour.min_value >= colour.max_value)
    mistakes.Add(where, key + ".min_value",
                 fmt::format("{:g} is not below max_value = {:g}: no pixel can match", colour.min_value,
                             colour.max_value));
}

}  // namespace kestrel::mission
