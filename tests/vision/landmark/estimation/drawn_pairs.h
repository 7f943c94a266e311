// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {

// Homographies of an image of 640 x 480, and pairs of points under them.
class DrawnPairs {
 public:
  explicit DrawnPairs(unsigned seed) : rng_(seed) {}
  double Normal() { return normal_(rng_); }
  Eigen::Vector2d Noise(double sigma) { return {sigma * Normal(), sigma * Normal()}; }
  Eigen::Vector2d Pixel() { return {640 * unit_(rng_), 480 * unit_(rng_)}; }
  // Turns, stretches and tilts the image, and never brings its horizon into it.
  Eigen::Matrix3d Homography() {
    Eigen::Matrix3d H;
    H << 1 + 0.2 * Normal(), 0.3 * Normal(), 80 * Normal(),  //
        0.3 * Normal(), 1 + 0.2 * Normal(), 80 * Normal(),   //
        2e-4 * std::tanh(Normal()), 2e-4 * std::tanh(Normal()), 1;
    return std::abs(H.determinant()) > 0.3 ? H : Homography();
  }
  // Among them one in each corner of the image.
  std::vector<PointPair> Spread(const Eigen::Matrix3d& H, int count, double sigma = 0) {
    std::vector<PointPair> pairs;
    for (int i = 0; i < count; ++i) {
      Eigen::Vector2d from = Pixel();
      if (i < 4) from = {(i % 2 ? 600 : 20) + 20 * from.x() / 640, (i / 2 ? 440 : 20) + 20 * from.y() / 480};
      pairs.push_back({from, Transfer(H, from) + Noise(sigma)});
    }
    return pairs;
  }
  // Replaces the first of them by nonsense.
  void Spoil(int count, std::vector<PointPair>& pairs) {
    for (int i = 0; i < count; ++i) pairs[i] = {Pixel(), Pixel()};
  }

 private:
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_;
};

// The greatest distance, px, between where two homographies take the points of an image.
inline double Difference(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  double most = 0;
  for (double x = 0; x <= 640; x += 80) {
    for (double y = 0; y <= 480; y += 80)
      most = std::max(most, (Transfer(A, {x, y}) - Transfer(B, {x, y})).norm());
  }
  return most;
}

inline std::vector<cv::Point2d> PointsOf(const std::vector<PointPair>& pairs,
                                         Eigen::Vector2d PointPair::*side) {
  std::vector<cv::Point2d> points;
  for (const PointPair& pair : pairs) points.emplace_back((pair.*side).x(), (pair.*side).y());
  return points;
}
inline std::vector<cv::Point2d> FromOf(const std::vector<PointPair>& pairs) {
  return PointsOf(pairs, &PointPair::from);
}
inline std::vector<cv::Point2d> ToOf(const std::vector<PointPair>& pairs) {
  return PointsOf(pairs, &PointPair::to);
}

}  // namespace kestrel::vision
