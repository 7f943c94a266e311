// SPDX-License-Identifier: Apache-2.0
#include "vision/target/balloon_tracker.h"

#include <cmath>
#include <utility>

namespace kestrel::vision {

namespace {

constexpr double kPlenty = 0.8;     // of the outline: no need to look any further
constexpr double kMaxGrowth = 1.3;  // of the half-angle from image to image

}  // namespace

BalloonTracker::BalloonTracker(const ColourModel& model, const CameraModel& camera,
                               const BalloonTrackerOptions& options)
    : camera_(camera), options_(options), colour_(model, options.colour) {}

void BalloonTracker::Begin(const cv::Rect2d& box) {
  colour_.Correct(box);
  before_.reset(), last_.reset();
  if (!(box.width > 0 && box.height > 0)) return;
  const Eigen::Vector2d centre(box.x + box.width / 2 - 0.5, box.y + box.height / 2 - 0.5);
  Eigen::Matrix<double, 3, 2> d_pixel;
  if (const auto axis = Ray(camera_, centre, &d_pixel))
    last_ = OutlineCone{*axis, (box.width + box.height) / 4 * d_pixel.norm() / std::sqrt(2.0)};
}

BalloonObservation BalloonTracker::Track(const cv::Mat& bgr, std::optional<OutlineCone> expected) {
  BalloonObservation seen;
  seen.track = colour_.Track(bgr);
  if (!expected && last_) {
    expected = last_;
    if (before_) {
      expected->axis = (2 * last_->axis - before_->axis).normalized();
      expected->half_angle = last_->half_angle * last_->half_angle / before_->half_angle;
    }
  }
  before_ = last_;
  last_.reset();
  const auto fitted = [&] { return seen.fit && seen.fit->state == FitState::kFitted; };
  if (expected) {
    // By its shape where it should be, whether or not its colour tells it there.
    seen.fit = FitBalloonNear(bgr, camera_, colour_.model(), *expected, options_.fit);
    const double grown = seen.fit->cone.half_angle / expected->half_angle;
    if (fitted() && (grown > kMaxGrowth || grown < 1 / kMaxGrowth)) seen.fit.reset();
  }
  if (seen.track.target && !(fitted() && seen.fit->outline > kPlenty)) {
    BalloonFit by_colour = FitBalloon(bgr, camera_, colour_.model(), seen.track.target->centre,
                                      seen.track.target->diameter_px, options_.fit);
    if (!fitted() || (by_colour.state == FitState::kFitted && by_colour.outline > seen.fit->outline))
      seen.fit = std::move(by_colour);
  }
  if (!seen.fit) return seen;
  if (seen.fit->state != FitState::kFitted) {
    // What is cut by the edge of the image or too small may well be the balloon.
    const bool whole = seen.track.state == TrackState::kTracked || seen.track.state == TrackState::kAmbiguous;
    if (whole && seen.fit->state == FitState::kTooLittleOutline &&
        ++not_round_frames_ >= options_.refuse_frames) {
      colour_.Refuse();
      not_round_frames_ = 0;
    }
    return seen;
  }
  not_round_frames_ = 0;
  seen.cone = last_ = seen.fit->cone;
  seen.features = FeaturesOf(seen.fit->cone, seen.fit->covariance);
  if (const auto box = OutlineBox(camera_, seen.fit->cone))
    colour_.Correct(*box & cv::Rect2d(0, 0, bgr.cols, bgr.rows));
  return seen;
}

}  // namespace kestrel::vision
