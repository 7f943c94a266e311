// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/vision/horizon/skyline_photographer.h"
#include "vision/camera/calibration_file.h"
#include "vision/camera/camera_model.h"

// Skies with balls before them, painted by directions: a pixel is a ball's for the share of its 8 x 8 rays
// that meet the ball.
namespace kestrel::vision {

struct FlyingBall {
  Eigen::Vector3d direction_N;  // from the camera, any length
  double half_angle = 0;        // rad
  Eigen::Vector3d colour{40, 40, 42};
};

// The four weathers, as the landscapes have them.
inline std::vector<PaintedWorld> FourSkies() {
  PaintedWorld clear, sun, overcast, sunset;
  clear.zenith = {178, 92, 41}, clear.horizon = {230, 209, 184}, clear.cloud = 12;
  clear.hills = [](double azimuth) { return Radians(2) * (1 + std::sin(5 * azimuth)); };
  sun.zenith = {194, 107, 56}, sun.horizon = {235, 212, 189}, sun.cloud = 8;
  sun.sun_N = Eigen::Vector3d(1, 0.3, -0.6);
  overcast.zenith = {181, 168, 158}, overcast.horizon = {207, 201, 196}, overcast.cloud = 14;
  overcast.haze_m = 3000;
  sunset.zenith = {113, 67, 48}, sunset.horizon = {77, 158, 250}, sunset.cloud = 14;
  sunset.ground = {30, 34, 36}, sunset.sun_N = Eigen::Vector3d(1, -0.2, -0.06);
  for (PaintedWorld* w : {&clear, &sun, &overcast, &sunset}) w->noise = 2;
  return {clear, sun, overcast, sunset};
}

inline CameraModel ForwardFisheye() {
  Mistakes mistakes;
  const CameraModel camera =
      LoadCamera(std::string(KESTREL_SOURCE_DIR) + "/models/cameras/fisheye.yaml", mistakes);
  mistakes.ThrowIfAny();
  return camera;
}

inline void PaintFlyingBalls(cv::Mat& image, const CameraModel& camera, const Eigen::Matrix3d& R_NC,
                             const std::vector<FlyingBall>& balls) {
  constexpr int kSide = 8;
  for (const FlyingBall& ball : balls) {
    const Eigen::Vector3d axis = R_NC.transpose() * ball.direction_N.normalized();
    const double edge = std::cos(ball.half_angle), reach = std::cos(ball.half_angle + 0.01);
    const auto centre = Project(camera, axis);
    if (!centre) continue;
    const int near = static_cast<int>(2 * WidthPx(camera) * ball.half_angle) + 8;  // px, more than enough
    const cv::Rect box = cv::Rect(static_cast<int>(centre->x()) - near, static_cast<int>(centre->y()) - near,
                                  2 * near, 2 * near) &
                         cv::Rect(0, 0, image.cols, image.rows);
    for (int y = box.y; y < box.br().y; ++y)
      for (int x = box.x; x < box.br().x; ++x) {
        const auto middle = Ray(camera, {x, y});
        if (!middle || middle->dot(axis) < reach) continue;
        int hits = 0;
        for (int s = 0; s < kSide * kSide; ++s) {
          const auto ray =
              Ray(camera, {x + (s % kSide + 0.5) / kSide - 0.5, y + (s / kSide + 0.5) / kSide - 0.5});
          hits += ray && ray->dot(axis) >= edge;
        }
        const double share = hits / static_cast<double>(kSide * kSide);
        auto& pixel = image.at<cv::Vec3b>(y, x);
        for (int k = 0; k < 3; ++k)
          pixel[k] = cv::saturate_cast<uchar>((1 - share) * pixel[k] + share * ball.colour[k]);
      }
  }
}

}  // namespace kestrel::vision
