// SPDX-License-Identifier: Apache-2.0
#include "vision/balloon_tracker.h"

namespace kestrel {

BalloonTracker::BalloonTracker(const ColourModel& model, const CameraModel& camera,
                               const BalloonTrackerOptions& options)
    : camera_(camera), options_(options), colour_(model, options.colour) {}

BalloonObservation BalloonTracker::Track(const cv::Mat& bgr) {
  BalloonObservation seen;
  seen.track = colour_.Track(bgr);
  std::optional<OutlineCone> expected = last_;
  if (last_ && before_) {  // it moves on as it did
    expected->axis = (2 * last_->axis - before_->axis).normalized();
    expected->half_angle = last_->half_angle * last_->half_angle / before_->half_angle;
  }
  before_ = last_;
  last_.reset();
  if (!seen.track.target) return seen;
  seen.fit = FitBalloon(bgr, camera_, colour_.model(), seen.track.target->centre,
                        seen.track.target->diameter_px, expected, options_.fit);
  if (seen.fit->state != FitState::kFitted) return seen;
  seen.cone = last_ = seen.fit->cone;
  seen.features = FeaturesOf(seen.fit->cone, seen.fit->covariance);
  if (const auto box = OutlineBox(camera_, seen.fit->cone))
    colour_.Correct(*box & cv::Rect2d(0, 0, bgr.cols, bgr.rows));
  return seen;
}

}  // namespace kestrel
