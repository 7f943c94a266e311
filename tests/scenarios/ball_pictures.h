// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "control/autopilot.h"
#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "mission/mission_type.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"
#include "vision/target/balloon_fit.h"

// Plain pictures of coloured balls for the missions that fly by them, drawn in a millisecond: a small pinhole
// that looks straight ahead, a grey background and noise that never repeats.
namespace kestrel::scenarios {

struct Ball {
  Eigen::Vector3d p_N{6, 0, -4};  // m
  double diameter_m = 0.5;
  cv::Scalar colour{30, 25, 215};  // blue, green, red
};

class BallPictures {
 public:
  static constexpr double kFocal_px = 190;
  static constexpr double kFrame_s = 0.05;

  static vision::CameraModel Camera() {
    return vision::Pinhole{320, 240, kFocal_px, kFocal_px, 159.5, 119.5};
  }
  static Pose Mount() {
    Eigen::Matrix3d R_BC;
    R_BC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    return {Eigen::Quaterniond(R_BC), Eigen::Vector3d::Zero()};
  }

  static mission::MissionParts Parts() {
    mission::MissionParts parts;
    parts.camera = Camera();
    parts.X_BC = Mount();
    return parts;
  }

  static cv::Mat Plain(const cv::Scalar& colour = {105, 115, 110}) {
    return cv::Mat(240, 320, CV_8UC3, colour);
  }

  // What the camera sees of balls from there.
  cv::Mat Draw(const std::vector<Ball>& balls, const control::VehicleState& state) {
    cv::Mat image = Plain();
    image.rowRange(200, 240).setTo(cv::Scalar(80, 95, 88));  // not blank without a ball
    for (const Ball& ball : balls) {
      const Eigen::Vector3d p_C = (Pose{state.R_NB, state.p_NB} * Mount()).Inverse() * ball.p_N;
      const auto cone = vision::ConeOfSphere(p_C, ball.diameter_m / 2);
      if (!cone || p_C.z() <= 0) continue;
      const auto box = vision::OutlineBox(Camera(), *cone);
      const cv::Rect part =
          box ? cv::Rect(cv::Rect2d(box->x - 2, box->y - 2, box->width + 4, box->height + 4) &
                         cv::Rect2d(0, 0, image.cols, image.rows))
              : cv::Rect();
      if (part.empty()) continue;
      std::vector<cv::Point> outline;  // in a mask of four times the size
      for (const Eigen::Vector2d& p : vision::DrawOutline(Camera(), *cone)) {
        const Eigen::Vector2d fine = 256 * (4 * (p - Eigen::Vector2d(part.x, part.y)).array() + 1.5);
        outline.emplace_back(static_cast<int>(std::lround(fine.x())),
                             static_cast<int>(std::lround(fine.y())));
      }
      cv::Mat mask(part.size() * 4, CV_8UC1, cv::Scalar(0)), share;
      cv::fillConvexPoly(mask, outline, cv::Scalar(255), cv::LINE_8, 8);
      cv::resize(mask, share, part.size(), 0, 0, cv::INTER_AREA);
      for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; ++x)
          for (int k = 0; k < 3; ++k) {
            uchar& value = image.at<cv::Vec3b>(part.y + y, part.x + x)[k];
            value =
                cv::saturate_cast<uchar>(value + share.at<uchar>(y, x) / 255.0 * (ball.colour[k] - value));
          }
    }
    return Noisy(image);
  }

  cv::Mat Noisy(const cv::Mat& image) {
    cv::Mat noise(image.size(), CV_16SC3), noisy;
    random_.fill(noise, cv::RNG::UNIFORM, -3, 4);
    cv::add(image, noise, noisy, {}, CV_8UC3);
    return noisy;
  }

 private:
  cv::RNG random_{12345};
};

inline control::VehicleState LevelAt(double t_s, const Eigen::Vector3d& p_N, double yaw) {
  control::VehicleState state;
  state.t_s = t_s;
  state.p_NB = p_N;
  state.R_NB = HeadingRotation(yaw);
  state.landed = false;
  return state;
}

}  // namespace kestrel::scenarios
