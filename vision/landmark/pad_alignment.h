// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/pinhole.h"
#include "vision/landmark/alignment/aligner.h"
#include "vision/landmark/pad_reference.h"
#include "vision/landmark/pad_tracking.h"

namespace kestrel::vision {

// The helipad by ICIA, thesis 4.4: its picture as the template, with a homography and the light, and Tukey's
// weights against shadows and what lies on it. Deviation: the template is the pad's known picture and not its
// place in the first image, which is the same with the homography of that image known without an error.
class PadAlignment {
 public:
  PadAlignment(const PadReference& reference, const Pinhole& camera, const PadTrackerOptions& options);

  void Look(const cv::Mat& grey);  // CV_8UC1: what Follow() looks at
  // The pad, from where it should be (from T, m, to the image). None: nothing there looks like it.
  std::optional<PadObservation> Follow(const Eigen::Matrix3d& H_predicted);
  // The same of a pad that moves so far between two images that its picture is blurred: the template is blurred
  // alike. Both of one scale, as HomographyFromPose() has it. The exposure, as a share of the time between two
  // images, is the one that explains the image best, and is tried first in the next.
  std::optional<PadObservation> FollowBlurred(const Eigen::Matrix3d& H_predicted,
                                              const Eigen::Matrix3d& H_last);

  // Of the last Follow() that found it: the points on the pad that the pose was taken from, px.
  const std::vector<Eigen::Vector2d>& points() const { return points_; }

 private:
  struct Template {
    cv::Mat picture;
    cv::Rect region;                 // of it
    std::optional<Aligner> aligner;  // made when first needed
    Eigen::Matrix3d pixel_from_T;
    double px_per_m = 0;
  };
  std::vector<Eigen::Vector2d> InView(const Eigen::Matrix3d& H_w) const;
  // The finest template that is worth its pixels; px_per_m: of the image.
  Template* Choose(const Eigen::Matrix3d& H_predicted, double& px_per_m);
  std::optional<PadObservation> Observe(const Alignment& found, const Template& chosen, double px_per_m,
                                        double min_sigma_px);

  Pinhole camera_;
  PadTrackerOptions options_;
  std::vector<Template> templates_;    // the finest first
  std::vector<Eigen::Vector2d> grid_;  // in T, m
  ImagePyramid image_;
  std::vector<Eigen::Vector2d> points_;
  double exposure_ = 0;  // as a share of the time between images; 0: unknown
};

}  // namespace kestrel::vision
