// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/camera/pinhole.h"
#include "vision/landmark/pad_reference.h"
#include "vision/landmark/pad_tracking.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {

// The part of the pad that lies in an image of that size, as a convex polygon in px; empty where there is none, or
// little.
std::vector<cv::Point2f> VisiblePart(const PadReference& reference, const Eigen::Matrix3d& H_w,
                                     const cv::Size& size);

// Of the corners that are tracked; where fewer agree, something misleads them: blur, a shadow, what hides the pad.
inline constexpr double kMostlyAgree = 0.6;

// What came of registering the pad's known picture to an image. Points are in px.
struct Registered {
  std::optional<PadObservation> seen;
  std::vector<Eigen::Vector2d> tracked;  // corners of the reference, where Lucas-Kanade found them
  std::vector<Eigen::Vector2d> agreed;   // those that one pose explains
  int coarser = 1;                       // than the image, where only so a pose was found
};

// Draws the reference as the camera would see it from where it is expected, and finds its corners in the image, by
// Lucas-Kanade and RANSAC. First in the exposure that the last image had; where most corners do not agree, also with
// the light evened out in both pictures, as a pad half in the shade needs it, and then at a half and a quarter of the
// resolution, as a print does that is seen from near or out of focus.
class PadRegistration {
 public:
  PadRegistration(const Pinhole& camera, const PadTrackerOptions& options)
      : camera_(camera), options_(options) {}

  // Of H_predicted, from T, m, to the image, which may be some px off. draw: of the consensus.
  Registered Register(const PadReference& reference, const cv::Mat& grey, const Eigen::Matrix3d& H_predicted,
                      int min_inliers, std::uint32_t draw);
  // The next image may be in another one.
  void ForgetExposure() { exposure_known_ = false; }

 private:
  // The part of the image that shows the pad, and the reference as it would be seen there.
  struct Sight {
    int coarser;                  // than the image
    cv::Mat seen, drawn, on_pad;  // CV_8UC1; on_pad: 255 where the pad is expected
    cv::Point2f offset;           // of that part, px
    Eigen::Matrix3d H_w;          // that is expected, from T, m, to the image that is so much coarser
    std::vector<Eigen::Vector2d> corners_T;  // that are looked for
    int window_px;                           // of Lucas-Kanade
    int evened_px;                           // over which light is evened out
  };
  struct Consensus {
    int min_inliers;
    std::uint32_t draw;
    double pad_area_m2;
  };
  using Matches = std::vector<PointPair>;  // that agree: drawn pixel to seen pixel

  std::optional<Sight> Look(const PadReference& reference, const cv::Mat& grey,
                            const Eigen::Matrix3d& H_predicted, int coarser) const;
  Registered InExposure(const Sight& sight, const Consensus& consensus);
  Registered InEvenLight(const Sight& sight, const Consensus& consensus) const;
  Registered Match(const cv::Mat& drawn, const cv::Mat& seen, const Sight& sight, const Consensus& consensus,
                   Matches& matches) const;
  void LearnExposure(const cv::Mat& drawn, const cv::Mat& seen, const Matches& matches);

  Pinhole camera_;
  PadTrackerOptions options_;
  double gain_ = 1, offset_ = 0;  // grey of the image = gain * grey of the reference + offset
  bool exposure_known_ = false;
};

}  // namespace kestrel::vision
