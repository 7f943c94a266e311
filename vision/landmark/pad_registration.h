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
#include "vision/landmark/patch/match_corners.h"
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
  int alike = 0;                         // corners that look like the reference: more cannot agree
  int coarser = 1;                       // than the image, where only so a pose was found
  Eigen::Matrix3d H_drawn;               // by which the reference was drawn, from T, m, to the image
};

// Draws the reference as the camera would see it from where it is expected, and finds its corners in the image, by
// Lucas-Kanade and RANSAC. A pad that is large in the image is drawn as a whole at a half or a quarter of the
// resolution; from where it is found so, patches about its corners are drawn and found in the image as it is. First
// in the exposure that the last image had. Where most corners do not agree, but a coarse look does not rule the
// pad out, also with the light evened out in both pictures, as a pad half in the shade needs it, and then at a
// half and a quarter of the resolution, as a print does that is seen from near or out of focus.
class PadRegistration {
 public:
  PadRegistration(const Pinhole& camera, const PadTrackerOptions& options)
      : camera_(camera), options_(options) {}

  // The cheap part of Register() alone: in the last image's exposure, of a pad that is where it is expected and in
  // focus. None: what most corners do not agree on.
  Registered RegisterPlain(const PadReference& reference, const cv::Mat& grey,
                           const Eigen::Matrix3d& H_predicted, int min_inliers, std::uint32_t draw);
  // Of H_predicted, from T, m, to the image, which may be some px off. draw: of the consensus.
  Registered Register(const PadReference& reference, const cv::Mat& grey, const Eigen::Matrix3d& H_predicted,
                      int min_inliers, std::uint32_t draw);
  // The next image may be in another one.
  void ForgetExposure() { exposure_.reset(); }

 private:
  // The part of the image that shows the pad, and the reference as it would be seen there.
  struct Sight {
    int coarser;                  // than the image
    cv::Mat seen, drawn, on_pad;  // CV_8UC1; on_pad: 255 where the pad is expected
    cv::Point2f offset;           // of that part, px
    Eigen::Matrix3d H_w;          // that is expected, from T, m, to the image that is so much coarser
    Eigen::Matrix3d H_predicted;  // the same to the image
    std::vector<Eigen::Vector2d> corners_T;  // that are looked for
    int window_px;                           // of Lucas-Kanade
    int evened_px;                           // over which light is evened out
  };
  struct Consensus {
    int min_inliers;
    std::uint32_t draw;
    double pad_area_m2;
  };
  // Where the reference is seen in an image.
  struct Place {
    Eigen::Matrix3d H_w;               // from T, m, to the image
    std::vector<cv::Point2f> visible;  // as VisiblePart()
    double px_per_m;
    const PadReference::Level* level;
    std::vector<Eigen::Vector2d> corners_T;  // that are looked for
  };
  // A corner of the reference, m, where it was drawn and where it is seen, px of the image.
  struct Match {
    Eigen::Vector2d corner_T, drawn, seen;
    GreySums greys;  // about it
  };

  std::optional<Place> PlaceOf(const PadReference& reference, const cv::Size& image,
                               const Eigen::Matrix3d& H_w) const;
  std::optional<Sight> Look(const PadReference& reference, const cv::Mat& grey,
                            const Eigen::Matrix3d& H_predicted, int coarser) const;
  Exposure ExposureOf(const Sight& sight) const;
  static cv::Mat DrawnIn(const Exposure& exposure, const Sight& sight);
  static std::vector<Match> Compare(const cv::Mat& drawn, const cv::Mat& seen, const Sight& sight);
  Registered CoarseToFine(const PadReference& reference, const cv::Mat& grey, const Sight& sight,
                          const Consensus& consensus);
  Registered InExposure(const Sight& sight, const Consensus& consensus);
  Registered InEvenLight(const Sight& sight, const Consensus& consensus) const;
  // greys: of the matches that agree.
  Registered Agree(const std::vector<Match>& matches, int coarser, const Eigen::Matrix3d& H_drawn,
                   const Consensus& consensus, GreySums& greys) const;
  void LearnExposure(const Exposure& drawn_in, const GreySums& greys);

  Pinhole camera_;
  PadTrackerOptions options_;
  std::optional<Exposure> exposure_;
};

}  // namespace kestrel::vision
