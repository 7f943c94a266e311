// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>

#include "geometry/pose.h"
#include "vision/aircraft/aircraft_lights.h"
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// A grey-green scene with the lights of an aircraft as discs, each pixel by 5 x 5 samples, and noise. hidden: of each
// light, in their order, whether it is not seen.
inline cv::Mat PhotographLights(const CameraModel& camera, const AircraftLights& lights, const Pose& X_CB,
                                unsigned seed, const std::vector<bool>& hidden = {}, double noise = 2) {
  cv::Mat image(HeightPx(camera), WidthPx(camera), CV_8UC3, cv::Scalar(96, 128, 112));
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    if (i < hidden.size() && hidden[i]) continue;
    const Eigen::Vector3d p_C = X_CB * lights.lights[i].position_m;
    const auto uv = Project(camera, p_C);
    if (!uv) continue;
    const double radius = lights.diameter_m / 2 * Parameters(camera)[0] / p_C.z();
    const cv::Vec3d colour = lights.lights[i].colour == 1 ? cv::Vec3d(234, 8, 255) : cv::Vec3d(106, 255, 8);
    const int reach = static_cast<int>(radius) + 2;
    for (int y = static_cast<int>(uv->y()) - reach; y <= static_cast<int>(uv->y()) + reach; ++y)
      for (int x = static_cast<int>(uv->x()) - reach; x <= static_cast<int>(uv->x()) + reach; ++x) {
        if (x < 0 || y < 0 || x >= image.cols || y >= image.rows) continue;
        int inside = 0;
        for (int k = 0; k < 25; ++k)
          inside += std::hypot(x + (k % 5 - 2) / 5.0 - uv->x(), y + (k / 5 - 2) / 5.0 - uv->y()) < radius;
        auto& pixel = image.at<cv::Vec3b>(y, x);
        for (int c = 0; c < 3; ++c)
          pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] + (colour[c] - pixel[c]) * inside / 25.0);
      }
  }
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        auto& value = image.at<cv::Vec3b>(y, x)[c];
        value = cv::saturate_cast<std::uint8_t>(value + normal(random));
      }
  return image;
}

}  // namespace kestrel::vision
