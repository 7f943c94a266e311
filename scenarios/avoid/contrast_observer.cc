// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/contrast_observer.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/drawn_colours.h"

namespace kestrel::scenarios {

ContrastObserver::ContrastObserver(const vision::CameraModel& camera, const Pose& X_BC,
                                   const cv::Mat& forbidden, const ContrastObserverParameters& parameters)
    : parameters_(parameters),
      camera_(camera),
      X_BC_(X_BC),
      tracker_(camera, forbidden, parameters.tracker) {}

void ContrastObserver::Observe(const vision::Frame& frame, const control::VehicleState& state, bool frozen,
                               double memory_s) {
  history_.Add(state);
  for (auto& [id, target] : targets_) target.AddState(state);
  now_s_ = state.t_s;
  frozen_ = frozen;
  seen_ = {};
  const auto then = history_.At(frame.t_s);
  if (!frozen && then) {
    seen_ = tracker_.Track(frame.image, (then->R_NB * X_BC_.R).toRotationMatrix(), frame.t_s);
    for (const vision::ContrastTarget& target : seen_.targets) {
      if (!target.confirmed) continue;
      auto [at, fresh] = targets_.try_emplace(target.id, X_BC_, parameters_.estimator);
      if (fresh) at->second.AddState(state);
      const vision::OutlineCone& cone = target.seen.cone;
      const double distance = parameters_.assumed_diameter_m / 2 / std::sin(cone.half_angle);
      const double across = distance * target.seen.axis_sigma;
      const double along = distance / std::tan(cone.half_angle) * target.seen.half_angle_sigma;
      const Eigen::Matrix3d in_axis = cone.axis * cone.axis.transpose();
      at->second.Correct(frame.t_s, distance * cone.axis,
                         across * across * (Eigen::Matrix3d::Identity() - in_axis) + along * along * in_axis);
    }
  }
  std::erase_if(targets_, [&](const auto& each) {
    const auto where = each.second.At(now_s_);
    return where && where->age_s > memory_s;
  });
}

std::vector<control::MovingTarget::Estimate> ContrastObserver::Known() const {
  std::vector<control::MovingTarget::Estimate> known;
  for (const auto& [id, target] : targets_)
    if (const auto where = target.At(now_s_)) known.push_back(*where);
  return known;
}

bool ContrastObserver::Sees() const {
  return !frozen_ && seen_.state != vision::ContrastState::kTooDark &&
         seen_.state != vision::ContrastState::kWhiteOut && seen_.state != vision::ContrastState::kBadImage;
}

std::string_view ContrastObserver::status() const { return frozen_ ? "frozen" : vision::NameOf(seen_.state); }

void ContrastObserver::Draw(cv::Mat& bgr) const {
  for (const vision::ContrastTarget& target : seen_.targets) {
    const cv::Point2d at(target.seen.centre_px.x(), target.seen.centre_px.y());
    const int radius = std::max(6, static_cast<int>(target.seen.diameter_px));
    cv::circle(bgr, at, radius, target.confirmed ? vision::kFixColour : vision::kPointColour,
               target.confirmed ? 2 : 1, cv::LINE_AA);
  }
}

}  // namespace kestrel::scenarios
