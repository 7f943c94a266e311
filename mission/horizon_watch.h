// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "control/estimate/horizon_filter.h"
#include "geometry/pose.h"
#include "mission/mission.h"
#include "vision/camera/camera_model.h"
#include "vision/horizon/horizon_attitude.h"

namespace kestrel {

// The attitude from the skyline and the heading from the surroundings, image by image, and the filter that
// joins them with the autopilot's rate gyros. Nothing of the autopilot's own attitude goes in.
class HorizonWatch {
 public:
  // forbidden: where the aircraft itself is seen, as in Skyline.
  HorizonWatch(const CameraModel& camera, const Pose& X_BC, const cv::Mat& forbidden);

  // Fills in the decision's target, attitude, coasting and time spent.
  void See(const Frame& frame, const VehicleState& state, Decision& decision);
  // At the time of the last state; the yaw counts from the first image with a heading. None until the first
  // attitude.
  std::optional<HorizonFilter::Estimate> Now() const { return filter_.Now(); }
  bool seen() const { return seen_; }  // an attitude, at least once
  void Draw(cv::Mat& bgr) const;

 private:
  HorizonAttitude::Expected Expect(const Frame& frame, const VehicleState& state);

  HorizonAttitude horizon_;
  HorizonFilter filter_;
  std::optional<HorizonAttitude::Measurement> measured_;
  double yaw_ = 0;                     // the filter's, at the exposure
  std::optional<double> last_turned_;  // by the compass
  double since_turned_ = 0;            // by the gyros, since then
  double coasting_s_ = 0;
  bool seen_ = false;
};

}  // namespace kestrel
