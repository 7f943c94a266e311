// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "tests/vision/horizon/skyline_photographer.h"
#include "vision/camera/camera_model.h"

// Shaded balls before a textured background, painted ray by ray by the definition of a sphere: whether a ray
// meets it, and with which normal. Knows nothing of cones or outlines.
namespace kestrel::vision {

struct PaintedBall {
  Eigen::Vector3d p_CT{0, 0, 4};  // m
  double radius = 0.25;
  Eigen::Vector3d colour{30, 25, 215};  // blue, green, red
  Eigen::Vector3d step = {0, 0, 0};     // m, over the exposure: motion blur
};

struct PaintedBalls {
  std::vector<PaintedBall> balls{PaintedBall{}};
  Eigen::Vector3d light_C = Eigen::Vector3d(-0.4, -0.8, -0.5);  // towards it
  double ambient = 0.55;                                        // of full light
  double brightness = 1;                                        // of all
  Eigen::Vector3d tint{1, 1, 1};
  Eigen::Vector3d ground{95, 120, 105}, sky{215, 190, 160};
  double rough = 25, noise = 2;  // grey levels
  // What is before and behind the balls by its direction: a colour, or nothing there.
  std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector3d&ray_C)> front, behind;
};

// 16 samples a pixel where a ball may be, one elsewhere.
inline cv::Mat PaintBalls(const CameraModel& camera, const PaintedBalls& w, int seed = 1) {
  constexpr int kSide = 4;
  const bool moves =
      std::any_of(w.balls.begin(), w.balls.end(), [](const PaintedBall& b) { return !b.step.isZero(); });
  const int instants = moves ? 5 : 1;
  cv::Mat image(HeightPx(camera), WidthPx(camera), CV_8UC3);
  cv::RNG rng(static_cast<std::uint64_t>(seed) * 77 + 5);
  cv::Mat noise(image.size(), CV_32FC3);
  rng.fill(noise, cv::RNG::NORMAL, 0, w.noise);
  const auto background = [&](const Eigen::Vector3d& r) -> Eigen::Vector3d {
    if (w.behind)
      if (const auto c = w.behind(r)) return *c;
    const double n = LatticeNoise(12 * r.x(), 12 * r.y(), 3) + 0.6 * LatticeNoise(40 * r.x(), 40 * r.y(), 4);
    const double share = std::clamp(0.5 + r.y() / 0.004, 0.0, 1.0);
    return (share * w.ground + (1 - share) * w.sky).array() + (0.3 + 0.7 * share) * w.rough * n;
  };
  const auto ball_at = [&](const PaintedBall& ball, double when, const Eigen::Vector3d& r,
                           Eigen::Vector3d& colour) {
    const Eigen::Vector3d p = ball.p_CT + when * ball.step;
    const double along = r.dot(p), inside = along * along - p.squaredNorm() + ball.radius * ball.radius;
    if (along <= 0 || inside < 0) return false;
    const Eigen::Vector3d normal = ((along - std::sqrt(inside)) * r - p) / ball.radius;
    colour = ball.colour * (w.ambient + (1 - w.ambient) * std::max(0.0, normal.dot(w.light_C.normalized())));
    return true;
  };
  const auto near_ball = [&](const Eigen::Vector3d& r) {
    return std::any_of(w.balls.begin(), w.balls.end(), [&](const PaintedBall& b) {
      const double reach = 1.1 * b.radius + b.step.norm() + 0.02 * b.p_CT.norm();
      return (b.p_CT.dot(r) * r - b.p_CT).squaredNorm() < reach * reach;
    });
  };
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      Eigen::Vector3d c = Eigen::Vector3d::Zero();
      const auto middle = Ray(camera, {x, y});
      if (middle) {
        const int side = near_ball(*middle) ? kSide : 1;
        for (int s = 0; s < side * side; ++s) {
          const auto ray =
              Ray(camera, {x + (s % side + 0.5) / side - 0.5, y + (s / side + 0.5) / side - 0.5});
          const Eigen::Vector3d r = ray ? *ray : *middle;
          const auto before = w.front ? w.front(r) : std::nullopt;
          const Eigen::Vector3d back = background(r);
          Eigen::Vector3d sum = Eigen::Vector3d::Zero();
          for (int i = 0; i < instants; ++i) {
            // A different instant for each sample: as smooth as many more of them.
            const double when = (i + (s + 0.5) / (side * side)) / instants - 0.5;
            Eigen::Vector3d colour = back;
            for (const PaintedBall& ball : w.balls)
              if (ball_at(ball, when, r, colour)) break;
            sum += before ? *before : colour;
          }
          c += sum / instants;
        }
        c = (w.brightness * c / (side * side)).cwiseProduct(w.tint);
        for (int k = 0; k < 3; ++k) c[k] += noise.at<cv::Vec3f>(y, x)[k];
      }
      for (int k = 0; k < 3; ++k) image.at<cv::Vec3b>(y, x)[k] = cv::saturate_cast<uchar>(c[k]);
    }
  return image;
}

}  // namespace kestrel::vision
