// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

#include "control/estimate/moving_target.h"
#include "geometry/pose.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"
#include "vision/target/balloon_tracker.h"

namespace kestrel {

// A coloured sphere whose diameter is known: a balloon, or the mark on another aircraft.
struct BalloonWatchParameters {
  ColourRange colour;
  double diameter_m = 0.5;
  double coast_s = 0.3;  // without a measurement for longer, its place is not known any more
  BalloonTrackerOptions tracker;
  MovingTargetOptions estimator;
};

template <class Visitor>
void Fields(Visitor& v, BalloonWatchParameters& p) {
  v("colour", p.colour);
  v("diameter_m", p.diameter_m, 0.02, 20.0);
  v("coast_s", p.coast_s, 0.05, 2.0);
  v("tracker", p.tracker);
  v("estimator", p.estimator);
}

// What every flight with a balloon shares: it sees it, and knows where it is and how it moves.
class BalloonWatch {
 public:
  BalloonWatch(const CameraModel& camera, const Pose& X_BC, const BalloonWatchParameters& parameters);

  // frozen: the image is the one before; it shows nothing.
  void See(const Frame& frame, const VehicleState& state, bool frozen);

  const BalloonWatchParameters& parameters() const { return parameters_; }
  bool Measured() const { return seen_ && seen_->cone; }  // in the last image
  bool Knows() const { return estimate_ && estimate_->age_s < parameters_.coast_s; }
  const MovingTarget::Estimate& where() const { return *estimate_; }  // now; only while it Knows()
  // The same from longer ago: where it would be now, had it gone on as it did.
  const std::optional<MovingTarget::Estimate>& last_known() const { return estimate_; }
  double age_s() const {
    return age_s_;
  }  // since the exposure that it was last measured in, or the beginning
  // Whether the last image could show it: not frozen, damaged, or all of its colour.
  bool Sees() const;
  TrackState state() const { return seen_ ? seen_->track.state : TrackState::kLost; }
  std::string_view status() const;  // of the last image, for the log

  void Draw(cv::Mat& bgr) const;  // the outline that was found

 private:
  BalloonWatchParameters parameters_;
  CameraModel camera_;
  BalloonTracker tracker_;
  MovingTarget target_;
  std::optional<BalloonObservation> seen_;  // none: frozen
  std::optional<MovingTarget::Estimate> estimate_;
  double age_s_ = 0;
};

}  // namespace kestrel
