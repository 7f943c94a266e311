// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "base/yaml/fields.h"
#include "vision/camera/camera_model.h"
#include "vision/target/balloon_fit.h"
#include "vision/target/colour_tracker.h"

namespace kestrel::vision {

struct BalloonTrackerOptions {
  ColourTrackerOptions colour;
  BalloonFitOptions fit;
  int refuse_frames = 5;
};

inline void Fields(FieldVisitor& v, BalloonTrackerOptions& o) {
  v({"colour", "search for the balloon's colour and its tracking by CamShift"}, o.colour);
  v({"fit", "measurement of the balloon by its outline"}, o.fit);
  v({"refuse_frames",
     "number of images in a row without a round outline after which another thing of its colour is tried"},
    o.refuse_frames, 1, 10000);
}

// By what a balloon is measured: the fit of its outline, or CamShift's own centre and diameter, which is what
// thesis 5.4.1 flies by.
enum class BalloonMeasure { kOutline, kCamShift };

struct BalloonObservation {
  ColourTrack track;
  std::optional<BalloonFit> fit;  // tried where colour or the last images say there is a balloon
  // The balloon's cone, and x, y and diameter of thesis (5.16), only if fitted, or as CamShift has them. There
  // may be a fitted cone without a target of the colour: before something of its colour, its outline alone
  // tells it.
  std::optional<OutlineCone> cone;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  // of the cone's axis (rank 2) and half-angle, rad
  std::optional<SphereFeatures> features;
};

// A balloon from image to image: CamShift finds and follows its colour, the fit of its outline measures it,
// and where the outline was found CamShift looks next. Thesis 5.4.1 takes CamShift's own centre and diameter,
// which move with whatever hides the balloon or looks like it; those of the outline do not, and hold at the
// edge of the image as well, as long as enough of it is seen. Measured by CamShift there is no fit, and nobody
// tells CamShift where to look.
class BalloonTracker {
 public:
  BalloonTracker(const ColourModel& model, const CameraModel& camera, const BalloonTrackerOptions& options,
                 BalloonMeasure measure = BalloonMeasure::kOutline);

  // Points at the balloon in the next image; without it, it is found by its colour. Box: as in OutlineBox().
  void Begin(const cv::Rect2d& box);
  // CV_8UC3 of the camera's size. expected: where it must be by whoever knows how the camera has turned and
  // moved; without it, it is looked for where it would be had its image moved on as it did.
  BalloonObservation Track(const cv::Mat& bgr, std::optional<OutlineCone> expected = {});

  const ColourTracker& colour() const { return colour_; }

 private:
  CameraModel camera_;
  BalloonTrackerOptions options_;
  BalloonMeasure measure_;
  ColourTracker colour_;
  std::optional<OutlineCone> last_, before_;  // of the last image and that before it, if fitted
  int not_round_frames_ = 0;
};

}  // namespace kestrel::vision
