// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/LU>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/camera_mount.h"
#include "vision/camera/pinhole.h"

// Flat ground at z = 0 of N, and what a camera sees of it, exactly known.
namespace kestrel::vision {

inline const Pinhole kGroundCamera{320, 240, 400, 400, 159.5, 119.5};

class DrawnGround {
 public:
  static constexpr double kPixel_m = 0.025;  // of its picture

  explicit DrawnGround(std::uint64_t seed = 1, cv::Size size = {1400, 1400}) {
    cv::Mat fine(size, CV_32F), coarse(size / 12, CV_32F);
    cv::RNG random(seed);
    random.fill(fine, cv::RNG::NORMAL, 0, 90);
    random.fill(coarse, cv::RNG::NORMAL, 0, 60);
    cv::GaussianBlur(fine, fine, {}, 2);
    cv::resize(coarse, coarse, size, 0, 0, cv::INTER_CUBIC);
    fine = 3 * fine + 0.6 * coarse + 128;
    fine.convertTo(picture, CV_8U);
  }

  // From an image's pixel to (x north, y east, 1) of N.
  static Eigen::Matrix3d GroundFromImage(const Pose& X_NC) {
    const Eigen::Matrix3d R = X_NC.R.toRotationMatrix();
    Eigen::Matrix3d ground;
    ground.row(0) = -X_NC.p.z() * R.row(0) + X_NC.p.x() * R.row(2);
    ground.row(1) = -X_NC.p.z() * R.row(1) + X_NC.p.y() * R.row(2);
    ground.row(2) = R.row(2);
    return ground * kGroundCamera.K().inverse();
  }
  cv::Mat Draw(const Pose& X_NC) const {
    Eigen::Matrix3d to_picture;
    to_picture << 0, 1 / kPixel_m, picture.cols / 2.0, -1 / kPixel_m, 0, picture.rows / 2.0, 0, 0, 1;
    cv::Mat map, image;
    cv::eigen2cv(Eigen::Matrix3d(to_picture * GroundFromImage(X_NC)), map);
    cv::warpPerspective(picture, image, map, {kGroundCamera.width_px, kGroundCamera.height_px},
                        cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REFLECT);
    return image;
  }
  // Of a camera that looks down, with so many degrees of yaw, pitch and roll.
  static Pose Above(double north, double east, double height, double yaw_deg = 0, double pitch_deg = 0,
                    double roll_deg = 0) {
    return Pose{Eigen::Quaterniond(
                    RotationFromTaitBryan({Radians(yaw_deg), Radians(pitch_deg), Radians(roll_deg)})),
                {north, east, -height}} *
           MountPose({.position_m = Eigen::Vector3d::Zero()});
  }

  cv::Mat picture;  // CV_8UC1
};

}  // namespace kestrel::vision
