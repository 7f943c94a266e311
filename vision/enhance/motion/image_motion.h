// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "vision/enhance/motion/motion_model.h"
#include "vision/enhance/motion/point_flow.h"

// How one image of a camera went over into another, thesis 4.1 and 4.2: pairs of points by pyramidal Lucas-Kanade or
// by features, and a motion model by RANSAC. Nothing depends on the number of threads.
namespace kestrel::vision {

struct ImageMotionOptions {
  std::string model = "homography";
  std::string method = "lk";
  int max_points = 300;
  int min_inliers = 12;
  double threshold_px = 1.5;
  bool opencl = false;
};

inline void Fields(FieldVisitor& v, ImageMotionOptions& o) {
  v({"model", "what an image may do from one to the next"}, o.model, MotionModelNames());
  v({"method",
     "lk: corners by pyramidal Lucas-Kanade, and features where it fails; sift, surf, orb: features alone"},
    o.method, {"lk", "sift", "surf", "orb"});
  v({"max_points", "maximum number of points in an image"}, o.max_points, 20, 5000);
  v({"min_inliers", "minimum number of points that must agree"}, o.min_inliers, 6, 500);
  v({"threshold_px", "maximum distance of an inlier"}, o.threshold_px, 0.1, 20.0);
  v({"opencl", "method lk: follow the points on a device of OpenCL, if there is one"}, o.opencl);
}

enum class MotionState {
  kFollowed,     // by Lucas-Kanade, or by the features asked for
  kRecovered,    // Lucas-Kanade failed, as where the image has jumped, and features found the motion
  kTextureless,  // too few points in one of the images
  kCut,          // both have points, which agree on no motion
  kResized,      // the images have different sizes
};
const char* NameOf(MotionState state);

struct ImageMotion {
  MotionState state = MotionState::kTextureless;
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity();  // from one image's pixels to the other's; if Known()
  int points = 0;                                   // pairs that were judged
  double rms_px = 0;                                // of the inliers
  std::vector<PointPair> inliers;                   // px

  bool Known() const { return state == MotionState::kFollowed || state == MotionState::kRecovered; }
};

// An image with what is made from it for this.
class MotionImage {
 public:
  // CV_8UC1, which is not copied.
  explicit MotionImage(const cv::Mat& grey, bool with_pyramid = true, bool opencl = false);
  MotionImage() = default;

  const cv::Mat& grey() const { return grey_; }
  const FlowPyramid& pyramid() const { return pyramid_; }
  // Corners (Shi and Tomasi 1994) of the image at half its size, spread over all of it; found when first asked for.
  const std::vector<cv::Point2f>& Corners(int max_points);

 private:
  cv::Mat grey_;
  FlowPyramid pyramid_;
  std::vector<cv::Point2f> corners_;
  int asked_ = 0;
};

// H_expected: from one to the other, roughly; none: they are much alike.
ImageMotion MotionBetween(MotionImage& from, MotionImage& to,
                          const std::optional<Eigen::Matrix3d>& H_expected,
                          const ImageMotionOptions& options);

}  // namespace kestrel::vision
