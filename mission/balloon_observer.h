// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "control/estimate/moving_target.h"
#include "geometry/pose.h"
#include "mission/decision.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"
#include "vision/target/balloon_tracker.h"

namespace kestrel::mission {

// A coloured sphere whose diameter is known: a balloon, or the mark on another aircraft.
struct BalloonObserverParameters {
  vision::ColourRange colour;
  double diameter_m = 0.5;
  double coast_s = 0.3;
  vision::BalloonTrackerOptions tracker;
  control::MovingTargetOptions estimator;
};

inline void Fields(FieldVisitor& v, BalloonObserverParameters& p) {
  v({"colour", "colour by which the balloon or mark is found"}, p.colour);
  v({"diameter_m", "true diameter of the balloon or mark, by which its distance is measured"}, p.diameter_m,
    0.02, 20.0);
  v({"coast_s",
     "time without a measurement after which the position of the balloon or mark counts as unknown"},
    p.coast_s, 0.05, 2.0);
  v({"tracker", "tracking of the balloon or mark from image to image"}, p.tracker);
  v({"estimator", "Kalman filter of the position and velocity of the balloon or mark"}, p.estimator);
}

// A range that no pixel can match is a mistake of its key.
void CheckColour(const vision::ColourRange& colour, const std::string& key, const Place& where,
                 Mistakes& mistakes);

// What every flight with a balloon shares: it sees it, and knows where it is and how it moves.
class BalloonObserver {
 public:
  BalloonObserver(const vision::CameraModel& camera, const Pose& X_BC,
                  const BalloonObserverParameters& parameters,
                  vision::BalloonMeasure measure = vision::BalloonMeasure::kOutline);

  // frozen: the image is the one before; it shows nothing.
  void Observe(const vision::Frame& frame, const control::VehicleState& state, bool frozen);

  const BalloonObserverParameters& parameters() const { return parameters_; }
  bool Measured() const { return seen_ && seen_->cone; }  // in the last image
  // What the last image says of it: a place or a direction in C, and x, y and diameter of thesis (5.16). Only
  // if Measured(); the features moreover only of what is before the camera.
  const vision::OutlineCone& cone() const { return *seen_->cone; }
  std::optional<vision::SphereFeatures> features() const { return seen_ ? seen_->features : std::nullopt; }
  bool HasEstimate() const { return estimate_ && estimate_->age_s < parameters_.coast_s; }
  const control::MovingTarget::Estimate& where() const {
    return *estimate_;
  }  // now; only while it HasEstimate()
  // The same from longer ago: where it would be now, had it gone on as it did.
  const std::optional<control::MovingTarget::Estimate>& last_known() const { return estimate_; }
  double age_s() const {
    return age_s_;
  }  // since the exposure that it was last measured in, or the beginning
  // Whether the last image could show it: not frozen, damaged, or all of its colour.
  bool Sees() const;
  vision::TrackState state() const { return seen_ ? seen_->track.state : vision::TrackState::kLost; }
  TargetState target_state() const;  // of the last image
  std::string_view status() const;   // the same in the tracker's word, for the log

  void Draw(cv::Mat& bgr) const;  // the outline that was found

 private:
  BalloonObserverParameters parameters_;
  vision::CameraModel camera_;
  vision::BalloonTracker tracker_;
  control::MovingTarget target_;
  std::optional<vision::BalloonObservation> seen_;  // none: frozen
  std::optional<control::MovingTarget::Estimate> estimate_;
  double age_s_ = 0;
};

}  // namespace kestrel::mission
