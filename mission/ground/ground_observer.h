// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "control/estimate/state_history.h"
#include "geometry/pose.h"
#include "vision/aircraft/ground_sight.h"
#include "vision/aircraft/light_pose.h"
#include "vision/capture/frozen_image.h"

namespace kestrel::mission {

// Where the aircraft is by one frame of the camera on the ground.
struct GroundFix {
  double t_s = 0;  // of the exposure
  Pose X_TB;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of the place in T by the image alone, m^2
  int lights = 0;
  double residual_px = 0;
};

enum class GroundState {
  kNoFrame,    // none has come yet
  kFound,      // the aircraft, in the whole image
  kTracked,    // where it was expected
  kLost,       // not seen, though it should be in the image
  kOutOfView,  // not seen, and expected beyond the image
  kFrozen,     // the image is the one before
  kClock,      // stamped in the future, or long before it came: its clock is not the autopilot's
};
const char* NameOf(GroundState state);

// Sees the aircraft from the ground: all frames that have come, each with the autopilot's attitude at its own
// exposure, and turns the head after the aircraft.
class GroundObserver {
 public:
  // A sight that has a stream.
  explicit GroundObserver(const vision::GroundSight& sight);

  // expected: where the aircraft was at a time, X_TB, as far as anything is known; it is asked for times of
  // exposures. Fixes are in the order of exposures.
  std::vector<GroundFix> Observe(const control::StateHistory& states, double now_s,
                                 const std::function<std::optional<Pose>(double)>& expected);

  GroundState state() const { return state_; }  // of the last frame
  double frame_s() const { return frame_s_; }   // the exposure of the last one; -1: none came

  // The last frame in colour, with the lights that were matched and the axes of the aircraft.
  cv::Mat Drawn() const;

 private:
  std::optional<GroundFix> Look(const vision::GroundFrame& frame, const Eigen::Quaterniond& R_NB,
                                const std::optional<Pose>& X_TB);
  cv::Rect Part(const Eigen::Vector2d& uv, double range_m) const;
  void TurnHead(double now_s, const std::optional<Pose>& X_TB);

  vision::GroundSight sight_;
  Pose X_TG_;
  vision::FrozenImage frozen_;
  vision::PanTilt head_;
  GroundState state_ = GroundState::kNoFrame;
  double frame_s_ = -1;
  int misses_ = 0;  // in the part of the image where it was expected
  std::optional<double> lost_since_s_;
  cv::Mat image_;
  std::vector<vision::LightSpot> spots_;
  std::optional<Pose> X_CB_;
};

}  // namespace kestrel::mission
