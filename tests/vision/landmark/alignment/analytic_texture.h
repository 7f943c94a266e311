// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "base/random.h"

namespace kestrel::vision {

// A texture that is known everywhere: a sum of waves, so that an image of it under any warp is exact.
class AnalyticTexture {
 public:
  explicit AnalyticTexture(std::uint64_t seed) {
    RandomStream random(seed, "analytic texture");
    for (int i = 0; i < 14; ++i) {
      const double length_px = 9 * std::pow(14.0, random.Uniform(0, 1)), turn = random.Uniform(0, 6.28);
      waves_.push_back({6.283 / length_px * Eigen::Vector2d(std::cos(turn), std::sin(turn)),
                        random.Uniform(0, 6.28), random.Uniform(5, 15)});
    }
  }
  double At(const Eigen::Vector2d& x) const {
    double grey = 128;
    for (const Wave& w : waves_) grey += w.grey * std::cos(w.per_px.dot(x) + w.phase);
    return grey;
  }
  // CV_32FC1: what is at x shows at W x; in another light, with noise.
  cv::Mat Image(const Eigen::Matrix3d& W, double gain = 1, double offset = 0, double noise_grey = 0) const {
    cv::Mat image(kRows, kCols, CV_32FC1);
    const Eigen::Matrix3d back = W.inverse();
    RandomStream random(1, "analytic noise");
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kCols; ++x) {
        const Eigen::Vector2d at = (back * Eigen::Vector3d(x, y, 1)).hnormalized();
        image.at<float>(y, x) =
            static_cast<float>(gain * At(at) + offset + (noise_grey > 0 ? noise_grey * random.Normal() : 0));
      }
    }
    return image;
  }
  static constexpr int kCols = 220, kRows = 190;

 private:
  struct Wave {
    Eigen::Vector2d per_px;
    double phase, grey;
  };
  std::vector<Wave> waves_;
};

}  // namespace kestrel::vision
