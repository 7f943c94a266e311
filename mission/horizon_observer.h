// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "control/estimate/horizon_filter.h"
#include "geometry/pose.h"
#include "mission/mission.h"
#include "vision/camera/camera_model.h"
#include "vision/horizon/horizon_attitude.h"

namespace kestrel::mission {

// What one image says of the attitude, before any filter.
struct AttitudeFix {
  double roll = 0, pitch = 0;              // rad
  double roll_sigma = 0, pitch_sigma = 0;  // rad, as the measurement itself states them
  std::optional<double> turned;            // rad, clockwise since the first image, over any number of turns
  double turned_sigma = 0;                 // rad
};

// The report of missions that measure the attitude.
struct HorizonReport final : MissionReport {
  std::optional<AttitudeFix> attitude;
  std::optional<double> coasting_s;     // for how long the gyros alone have carried the camera's attitude
  std::optional<AttitudeFix> baseline;  // by the reference method, where both are compared
};

// The attitude from the skyline and the heading from the surroundings, image by image, and the filter that
// joins them with the autopilot's rate gyros. Nothing of the autopilot's own attitude goes in.
class HorizonObserver {
 public:
  // forbidden: where the aircraft itself is seen, as in Skyline.
  HorizonObserver(const vision::CameraModel& camera, const Pose& X_BC, const cv::Mat& forbidden);

  // Fills in the decision's target and time spent. Returns a report without a baseline.
  HorizonReport Observe(const vision::Frame& frame, const control::VehicleState& state, Decision& decision);
  // At the time of the last state; the yaw counts from the first image with a heading. None until the first
  // attitude.
  std::optional<control::HorizonFilter::Estimate> Now() const { return filter_.Now(); }
  bool seen() const { return seen_; }  // an attitude, at least once
  void Draw(cv::Mat& bgr) const;
  std::vector<Caption> Captions(std::string_view phase) const;

 private:
  vision::HorizonAttitude::Expected Expect(const vision::Frame& frame, const control::VehicleState& state);

  vision::HorizonAttitude horizon_;
  control::HorizonFilter filter_;
  std::optional<vision::HorizonAttitude::Measurement> measured_;
  double yaw_ = 0;                     // the filter's, at the exposure
  std::optional<double> last_turned_;  // by the compass
  double since_turned_ = 0;            // by the gyros, since then
  double coasting_s_ = 0;
  bool seen_ = false;
};

}  // namespace kestrel::mission
