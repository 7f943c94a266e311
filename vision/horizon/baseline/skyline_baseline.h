// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/camera_model.h"

// Attitude and heading as thesis 6.3 has them, kept to compare with. Made for a catadioptric camera that
// looks along the aircraft's vertical: ground in the middle of the image, sky around it.
namespace kestrel::vision {

// 3 B^2 / (R + G + B) of an image in the order blue, green, red (CV_8UC3): CV_8UC1, clipped; 0 for black.
cv::Mat SkyWeight(const cv::Mat& image);

struct BaselineAttitude {
  Eigen::Vector3d down_B;
  double roll = 0, pitch = 0;  // rad
  cv::RotatedRect ellipse;     // in the image, px
  cv::Mat segments;            // CV_8UC1, the sky weight of each segment
  cv::Mat ground;              // CV_8UC1, 255 where the segmentation says ground
};

// 6.3.1 to 6.3.3: SkyWeight, the segmentation by a pyramid, a gaussian adaptive threshold, the largest contour
// of ground, the ellipse fitted to it, its points back on the sphere, (6.15) in B, (6.16). The window of the
// threshold is a share of the image. None: no contour, or an ellipse off the lens.
class SkylineBaseline {
 public:
  SkylineBaseline(const CameraModel& camera, const Eigen::Matrix3d& R_BC);
  std::optional<BaselineAttitude> Measure(const cv::Mat& image) const;

 private:
  CameraModel camera_;
  Eigen::Matrix3d R_BC_;
  cv::Mat lens_;  // CV_8UC1, 255 where the lens shows something
};

// 6.3.4: the heading by the shift of the front 120 degrees of a polar panorama, added up from image to image.
class CompassBaseline {
 public:
  static constexpr double kField_deg = 120;  // of its front part

  // centre, radii: of the ring that is unwrapped, px. nose: the angle in the image, from its x towards its y,
  // at which the nose is seen. clockwise: +1 where that angle grows with the azimuth, or -1.
  struct Ring {
    Eigen::Vector2d centre;
    double radius_inner = 0, radius_outer = 0;
    double nose = 0;
    int clockwise = 1;
    int width_px = 240, height_px = 40;
  };
  CompassBaseline(const CameraModel& camera, const Ring& ring);

  // The heading since the first image, rad.
  double Turn(const cv::Mat& image);

  // The appearance image of (6.17), and how many columns another like it is shifted, by (6.18).
  cv::Mat Unwrap(const cv::Mat& image) const;
  static int BestShift(const cv::Mat& a, const cv::Mat& b);

  // (6.18) per pixel of what overlaps, for b's columns shifted by k: the distance of a(i) and b(i + k).
  static double Distance(const cv::Mat& a, const cv::Mat& b, int shift);

 private:
  cv::Mat map_;  // CV_32FC2
  int clockwise_;
  double per_column_;  // rad
  cv::Mat last_;
  double total_ = 0;
};

// The ring that the flights unroll, of a camera that looks straight down: from a little above the horizon to 30
// degrees below it, where the ground is still far away.
CompassBaseline::Ring GroundRing(const CameraModel& camera, const Eigen::Matrix3d& R_BC, double px_per_deg);

}  // namespace kestrel::vision
