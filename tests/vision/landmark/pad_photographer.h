// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/pinhole.h"

// Images of a pad on the ground from known poses, made by warping alone: independent of any renderer.
namespace kestrel::vision {

inline constexpr double kPadLength_m = 1.19, kPadWidth_m = 0.91;
inline const Pinhole kPadCamera{640, 480, 810.81, 810.81, 319.5, 239.5};

inline cv::Mat PadPicture() {
  const std::string path = std::string(KESTREL_SOURCE_DIR) + "/models/pads/helipad/helipad.png";
  cv::Mat picture = cv::imread(path, cv::IMREAD_GRAYSCALE);
  if (picture.empty()) throw std::runtime_error("cannot read " + path);
  return picture;
}

// To one side, along a line aslant; light: of what is left there.
inline cv::Mat HalfInTheShade(cv::Mat picture, double light) {
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      if (x + 0.4 * y < 0.5 * picture.cols + 0.2 * picture.rows)
        picture.at<uchar>(y, x) = cv::saturate_cast<uchar>(light * picture.at<uchar>(y, x));
  return picture;
}

// X_CT of a camera above the pad: place of the pad on the optical axes, m; yaw of the pad in the image; tilt
// of the camera about its own x and y.
inline Pose PadBelow(const Eigen::Vector3d& p_CT, double yaw_deg, double tilt_x_deg = 0,
                     double tilt_y_deg = 0) {
  return {ExpRotation({Radians(tilt_x_deg), Radians(tilt_y_deg), 0}) * HeadingRotation(Radians(yaw_deg)),
          p_CT};
}

// A hovering aircraft's view: it sways, turns and tilts; 15 frames a second.
inline Pose PathPose(int frame, double height_m = 4.2) {
  const double t = frame / 15.0;
  return PadBelow({0.25 * std::sin(1.1 * t), 0.2 * std::sin(0.8 * t + 1), height_m + 0.2 * std::sin(0.6 * t)},
                  40 + 15 * std::sin(0.5 * t), 4 * std::sin(1.4 * t), 3 * std::sin(1.9 * t));
}

class PadPhotographer {
 public:
  // An empty picture: ground alone.
  explicit PadPhotographer(const cv::Mat& picture) : ground_(kGroundSide_px, kGroundSide_px, CV_8UC1) {
    cv::RNG rng(11);
    cv::Mat sum(ground_.size(), CV_32FC1, cv::Scalar(105));
    for (const int coarse : {4, 16, 64}) {  // rough at several scales, like grass and gravel
      cv::Mat blotches(kGroundSide_px / coarse, kGroundSide_px / coarse, CV_32FC1), large;
      rng.fill(blotches, cv::RNG::NORMAL, 0, 14);
      cv::resize(blotches, large, sum.size(), 0, 0, cv::INTER_CUBIC);
      sum += large;
    }
    sum.convertTo(ground_, CV_8U);
    for (cv::Mat level = picture; !level.empty() && level.cols > 40;) {
      pictures_.push_back(level);
      cv::Mat half;
      cv::resize(level, half, {level.cols / 2, level.rows / 2}, 0, 0, cv::INTER_AREA);
      level = half;
    }
  }

  // Each pixel is the mean of kFine x kFine samples; grey = gain * grey + offset, then noise of two levels.
  cv::Mat At(const Pose& X_CT, int noise_seed, double gain = 1, double offset = 0) const {
    Eigen::Matrix3d M;  // eq. (3.18) by hand: the plane z = 0 of T
    M << X_CT.R.toRotationMatrix().leftCols<2>(), X_CT.p;
    Eigen::Matrix3d fine;
    fine << kFine, 0, (kFine - 1) / 2.0, 0, kFine, (kFine - 1) / 2.0, 0, 0, 1;
    const Eigen::Matrix3d from_T = fine * kPadCamera.K() * M;
    cv::Mat image(kFine * kPadCamera.height_px, kFine * kPadCamera.width_px, CV_8UC1, cv::Scalar(105));
    Warp(ground_, kGroundSide_m, kGroundSide_m, from_T, cv::BORDER_REFLECT, image);
    if (!pictures_.empty()) {
      const double px_per_m = kFine * kPadCamera.fx / X_CT.p.z();
      std::size_t level = 0;
      while (level + 1 < pictures_.size() && pictures_[level + 1].cols / kPadWidth_m > px_per_m) ++level;
      Warp(pictures_[level], kPadLength_m, kPadWidth_m, from_T, cv::BORDER_TRANSPARENT, image);
    }
    cv::Mat seen, noise(kPadCamera.height_px, kPadCamera.width_px, CV_32FC1);
    cv::resize(image, seen, noise.size(), 0, 0, cv::INTER_AREA);
    cv::RNG rng(static_cast<std::uint64_t>(noise_seed) + 1);
    rng.fill(noise, cv::RNG::NORMAL, 0, 2);
    seen.convertTo(seen, CV_32F, gain, offset);
    seen += noise;
    seen.convertTo(seen, CV_8U);
    return seen;
  }

 private:
  static constexpr int kFine = 2;
  static constexpr int kGroundSide_px = 1024;
  static constexpr double kGroundSide_m = 16;

  // A picture of length x width, m, with x of T up and y right.
  static void Warp(const cv::Mat& picture, double length_m, double width_m, const Eigen::Matrix3d& from_T,
                   int border, cv::Mat& image) {
    Eigen::Matrix3d T_from_pixel;
    T_from_pixel << 0, -length_m / picture.rows, length_m / 2 - 0.5 * length_m / picture.rows,  //
        width_m / picture.cols, 0, -width_m / 2 + 0.5 * width_m / picture.cols,                 //
        0, 0, 1;
    cv::Mat map;
    cv::eigen2cv(Eigen::Matrix3d(from_T * T_from_pixel), map);
    cv::warpPerspective(picture, image, map, image.size(), cv::INTER_LINEAR, border);
  }

  cv::Mat ground_;
  std::vector<cv::Mat> pictures_;  // halves of each other, the finest first
};

}  // namespace kestrel::vision
