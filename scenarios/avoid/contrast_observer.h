// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

#include "base/yaml/fields.h"
#include "control/estimate/moving_target.h"
#include "control/estimate/state_history.h"
#include "geometry/pose.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"
#include "vision/target/contrast_tracker.h"

namespace kestrel::scenarios {

// Others without a mark, by their contrast with the sky. What they measure is not known: a diameter is
// assumed. If they are larger they are taken to be nearer and slower than they are, which leaves the time
// until they are closest as it is, and makes the closest distance smaller: the error is on the safe side.
struct ContrastObserverParameters {
  double assumed_diameter_m = 0.5;
  vision::ContrastTrackerOptions tracker;
  control::MovingTargetOptions estimator{1, 0.3};
};

inline void Fields(FieldVisitor& v, ContrastObserverParameters& p) {
  v({"assumed_diameter_m", "diameter that is assumed of other aircraft, by which their distance is measured"},
    p.assumed_diameter_m, 0.05, 100.0);
  v({"tracker", "detection and tracking of other aircraft against the sky"}, p.tracker);
  v({"estimator", "Kalman filter of the position and velocity of each other aircraft"}, p.estimator);
}

class ContrastObserver {
 public:
  // forbidden: where the aircraft itself is seen.
  ContrastObserver(const vision::CameraModel& camera, const Pose& X_BC, const cv::Mat& forbidden,
                   const ContrastObserverParameters& parameters);

  // frozen: the image is the one before; it shows nothing. memory_s: who was not seen for longer is
  // forgotten.
  void Observe(const vision::Frame& frame, const control::VehicleState& state, bool frozen, double memory_s);

  std::vector<control::MovingTarget::Estimate> Known()
      const;          // now, by the last sight of each; as if of the assumed size
  bool Sees() const;  // whether the last image could show any: not frozen, dark, white or damaged
  std::string_view status() const;  // of the last image, for the log
  void Draw(cv::Mat& bgr) const;

 private:
  ContrastObserverParameters parameters_;
  vision::CameraModel camera_;
  Pose X_BC_;
  vision::ContrastTracker tracker_;
  control::StateHistory history_;
  std::map<int, control::MovingTarget> targets_;  // by the tracker's ids
  vision::ContrastObservation seen_;
  bool frozen_ = false;
  double now_s_ = 0;
};

}  // namespace kestrel::scenarios
