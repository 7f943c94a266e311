// SPDX-License-Identifier: Apache-2.0
#include "vision/target/balloon_tracker.h"

#include <cmath>
#include <utility>

namespace kestrel::vision {

namespace {

constexpr double kPlenty = 0.8;     // of the outline: no need to look any further
constexpr double kMaxGrowth = 1.3;  // of the half-angle from image to image
// Standard deviations of CamShift's centre, px, and of its diameter, as a share of that.
constexpr double kCamShiftCentre_px = 1, kCamShiftDiameter = 0.05;

// What CamShift says of a target, as rays: its circle is taken for the outline. Its features are the pixels
// over the focal length, as thesis (5.16) has them.
void MeasureByCamShift(const CameraModel& camera, BalloonObservation& seen) {
  if (!seen.track.target || seen.track.state == TrackState::kTooClose) return;
  Eigen::Matrix<double, 3, 2> d_pixel;
  const auto axis = Ray(camera, seen.track.target->centre, &d_pixel);
  if (!axis) return;
  const double diameter_px = seen.track.target->diameter_px;
  const double rad_per_px = std::sqrt(d_pixel.col(0).cross(d_pixel.col(1)).norm());
  seen.cone = OutlineCone{*axis, diameter_px / 2 * rad_per_px};
  const double sigma = kCamShiftCentre_px * rad_per_px;
  seen.covariance.topLeftCorner<3, 3>() =
      sigma * sigma * (Eigen::Matrix3d::Identity() - *axis * axis->transpose());
  seen.covariance(3, 3) = std::pow(kCamShiftDiameter * seen.cone->half_angle, 2);
  seen.features = FeaturesOf(*seen.cone, seen.covariance);
  if (!seen.features) return;
  const Eigen::Matrix2d d_xy =
      (d_pixel.topRows<2>() - axis->head<2>() / axis->z() * d_pixel.row(2)) / axis->z();
  seen.features->xyd.z() = diameter_px * std::sqrt(std::abs(d_xy.determinant()));
}

}  // namespace

BalloonTracker::BalloonTracker(const ColourModel& model, const CameraModel& camera,
                               const BalloonTrackerOptions& options, BalloonMeasure measure)
    : camera_(camera), options_(options), measure_(measure), colour_(model, options.colour) {}

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
  if (measure_ == BalloonMeasure::kCamShift) {
    MeasureByCamShift(camera_, seen);
    return seen;
  }
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
  seen.covariance = seen.fit->covariance;
  seen.features = FeaturesOf(seen.fit->cone, seen.fit->covariance);
  if (const auto box = OutlineBox(camera_, seen.fit->cone))
    colour_.Correct(*box & cv::Rect2d(0, 0, bgr.cols, bgr.rows));
  return seen;
}

}  // namespace kestrel::vision
