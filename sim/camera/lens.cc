// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/lens.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/random.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr int kParts = 8;  // along each side of a pixel, to find how much of it an edge covers

// The mean over a pixel of a function of the place.
template <class Function>
double MeanOverPixel(const Eigen::Vector2d& uv, Function&& f) {
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j)
      sum += f(Eigen::Vector2d(uv.x() + (i + 0.5) / kParts - 0.5, uv.y() + (j + 0.5) / kParts - 0.5));
  }
  return sum / (kParts * kParts);
}

Eigen::Vector2d PrincipalPoint(const vision::CameraModel& camera) {
  return std::visit([](const auto& c) { return Eigen::Vector2d(c.cx, c.cy); }, camera);
}

// The discrete analogue of the Gaussian (Lindeberg 1990): exp(-s^2) I_n(s^2) has the variance s^2 exactly,
// however narrow, which samples of the Gaussian itself do not.
cv::Mat GaussianKernel(double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma)) + 1;
  cv::Mat kernel(2 * reach + 1, 1, CV_32F);
  double sum = 0;
  std::vector<double> weights(reach + 1);
  for (int n = 0; n <= reach; ++n) {
    weights[n] = std::exp(-sigma * sigma) * std::cyl_bessel_i(static_cast<double>(n), sigma * sigma);
    sum += (n == 0 ? 1 : 2) * weights[n];
  }
  for (int n = -reach; n <= reach; ++n)
    kernel.at<float>(reach + n) = static_cast<float>(weights[std::abs(n)] / sum);
  return kernel;
}

cv::Mat DiscKernel(double radius) {
  const int reach = static_cast<int>(std::ceil(radius - 0.5));
  cv::Mat kernel(2 * reach + 1, 2 * reach + 1, CV_32F);
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      kernel.at<float>(reach + y, reach + x) = static_cast<float>(
          MeanOverPixel({x, y}, [&](const Eigen::Vector2d& p) { return p.norm() <= radius ? 1.0 : 0.0; }));
    }
  }
  return kernel / cv::sum(kernel)[0];
}

void Dust(const DustParameters& dust, std::uint64_t seed, cv::Mat& shade) {
  RandomStream random(seed, "dust");
  const int reach = static_cast<int>(std::ceil(4 * dust.size_px));
  for (int i = 0; i < dust.count; ++i) {
    const double u = random.Uniform(-0.5, shade.cols - 0.5), v = random.Uniform(-0.5, shade.rows - 0.5);
    const int left = std::max(0, static_cast<int>(u) - reach), top = std::max(0, static_cast<int>(v) - reach);
    for (int y = top; y < std::min(shade.rows, top + 2 * reach + 1); ++y)
      for (int x = left; x < std::min(shade.cols, left + 2 * reach + 1); ++x) {
        const double r2 = ((x - u) * (x - u) + (y - v) * (y - v)) / (dust.size_px * dust.size_px);
        shade.at<float>(y, x) *= static_cast<float>(1 - dust.darkness * std::exp(-r2 / 2));
      }
  }
}

}  // namespace

cv::Mat Shade(const LensParameters& lens, const vision::CameraModel& camera, std::uint64_t seed) {
  const bool falls_off = lens.cos_power > 0 || !lens.vignetting.isZero(0);
  if (!falls_off && lens.rim_px <= 0 && lens.reflection_deg <= 0 && lens.dust.count <= 0) return {};
  cv::Mat shade(vision::HeightPx(camera), vision::WidthPx(camera), CV_32F);
  const Eigen::Vector2d centre = PrincipalPoint(camera);
  const double half_diagonal = std::hypot(shade.cols, shade.rows) / 2;
  const double reflection_rad = Radians(lens.reflection_deg);
  const auto angle_of = [&](const Eigen::Vector2d& uv) -> std::optional<double> {
    const auto ray = vision::Ray(camera, uv);
    if (!ray) return std::nullopt;
    return std::atan2(ray->head<2>().norm(), ray->z());
  };
  const auto mirrored = [&](const Eigen::Vector2d& uv) {
    const auto angle = angle_of(uv);
    return angle && *angle < reflection_rad;
  };
  for (int y = 0; y < shade.rows; ++y) {
    for (int x = 0; x < shade.cols; ++x) {
      const Eigen::Vector2d uv(x, y);
      double share = 1;
      if (falls_off) {
        const double r2 = (uv - centre).squaredNorm() / (half_diagonal * half_diagonal);
        share = 1 + r2 * (lens.vignetting[0] + r2 * (lens.vignetting[1] + r2 * lens.vignetting[2]));
        const auto angle = angle_of(uv);
        share *= angle ? std::pow(std::max(0.0, std::cos(*angle)), lens.cos_power) : 0;
      }
      // Only a pixel that an edge may cross is looked at in parts.
      const double off = lens.rim_px > 0 ? (uv - centre).norm() - lens.rim_px : -1;
      if (off > -1)
        share *= off >= 1 ? 0 : MeanOverPixel(uv, [&](const Eigen::Vector2d& p) {
          return (p - centre).norm() <= lens.rim_px ? 1.0 : 0.0;
        });
      if (reflection_rad > 0) {
        const auto corner = [&](double dx, double dy) { return mirrored(uv + Eigen::Vector2d(dx, dy)); };
        const int corners = corner(-0.5, -0.5) + corner(0.5, -0.5) + corner(-0.5, 0.5) + corner(0.5, 0.5);
        const bool holds_axis = (uv - centre).cwiseAbs().maxCoeff() <= 0.5;
        if (corners == 4) {
          share = 0;
        } else if (corners > 0 || holds_axis) {
          share *= MeanOverPixel(uv, [&](const Eigen::Vector2d& p) { return mirrored(p) ? 0.0 : 1.0; });
        }
      }
      shade.at<float>(y, x) = static_cast<float>(std::max(0.0, share));
    }
  }
  Dust(lens.dust, seed, shade);
  return shade;
}

Defocus::Defocus(const LensParameters& lens) {
  if (lens.defocus_px <= 0) return;
  kernel_ = lens.defocus == "disc" ? DiscKernel(lens.defocus_px) : GaussianKernel(lens.defocus_px);
}

cv::Mat Defocus::Spread(const cv::Mat& light) const {
  cv::Mat spread;
  if (kernel_.cols == 1) {
    cv::sepFilter2D(light, spread, CV_32F, kernel_, kernel_, {-1, -1}, 0, cv::BORDER_REPLICATE);
  } else {
    cv::filter2D(light, spread, CV_32F, kernel_, {-1, -1}, 0, cv::BORDER_REPLICATE);
  }
  return spread;
}

}  // namespace kestrel::sim
