// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/corner_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kMinContrast = 12;  // grey levels between white and black
constexpr double kMinCorrelation = 0.6;
constexpr double kMaxMisfit = 0.15;  // of what the fit leaves, over the contrast
constexpr int kMaxSteps = 30;
constexpr double kDone_px = 1e-4;

// One edge: its direction, the side on which the other axis lies, its curvature to that side.
struct Edge {
  Vector2d along, side;
  double bend = 0, turn = 1;  // side = turn * (along turned from u to v)

  Edge(const Vector2d& direction, const Vector2d& other, double curvature) : bend(curvature) {
    along = direction.normalized();
    side = {-along.y(), along.x()};
    if (side.dot(other) < 0) turn = -1, side = -side;
  }
  void Rotate(double angle) {
    along = Eigen::Rotation2Dd(angle) * along;
    side = Eigen::Rotation2Dd(angle) * side;
  }
  // Signed distance of a point d from the corner, and its derivatives by d and by the edge's angle. Blur of a
  // deviation moves the middle grey of a bent edge to its inside.
  double Distance(const Vector2d& d, double blur, Vector2d& d_d, double& d_angle) const {
    const double t = along.dot(d), n = side.dot(d);
    d_d = side - bend * t * along;
    d_angle = -turn * t - bend * t * turn * n;
    return n - bend / 2 * (t * t + blur * blur);
  }
};

// 1 well inside, 0 at the rim: so that no pixel enters or leaves abruptly as the corner moves.
double Weight(double distance, double radius) {
  const double outer = std::clamp((distance / radius - 0.7) / 0.3, 0.0, 1.0);
  return 0.5 + 0.5 * std::cos(std::numbers::pi * outer);
}

bool Inside(const cv::Mat& grey, const Vector2d& at, double radius) {
  return at.x() - radius >= 0 && at.y() - radius >= 0 && at.x() + radius <= grey.cols - 1 &&
         at.y() + radius <= grey.rows - 1;
}

}  // namespace

std::optional<FittedCorner> FitCorner(const cv::Mat& grey, const CornerGuess& guess) {
  const double radius = guess.radius_px, black = guess.black_between ? -1 : 1;
  Edge x(guess.along_x, guess.along_y, guess.bend_x), y(guess.along_y, guess.along_x, guess.bend_y);
  Vector2d p = guess.pixel;
  double blur = 0.7;
  // Of the model, in this order: p, the two angles, blur, then linear ones: mean, half contrast, slope.
  constexpr int kSize = 9;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  Eigen::Matrix<double, 4, 1> light = Eigen::Matrix<double, 4, 1>::Zero();
  bool have_light = false;
  const Eigen::Index most = static_cast<Eigen::Index>((2 * radius + 2) * (2 * radius + 2));
  Eigen::Matrix<double, kSize, Eigen::Dynamic> jacobian(kSize, most), weighted(kSize, most);
  Eigen::VectorXd residuals(most);

  for (int step = 0; step < kMaxSteps; ++step) {
    if (!Inside(grey, p, radius) || !((p - guess.pixel).norm() <= radius / 2)) return std::nullopt;
    int rows = 0;
    double square = 0, weights = 0;
    for (int v = static_cast<int>(std::ceil(p.y() - radius)); v <= p.y() + radius; ++v) {
      for (int u = static_cast<int>(std::ceil(p.x() - radius)); u <= p.x() + radius; ++u) {
        const Vector2d d = Vector2d(u, v) - p;
        const double weight = Weight(d.norm(), radius);
        if (!(weight > 0)) continue;
        Vector2d dx_d, dy_d;
        double dx_angle, dy_angle;
        const double sx = x.Distance(d, blur, dx_d, dx_angle), sy = y.Distance(d, blur, dy_d, dy_angle);
        const double ex = std::erf(sx / (std::numbers::sqrt2 * blur));
        const double ey = std::erf(sy / (std::numbers::sqrt2 * blur));
        const double peak = std::sqrt(2 / std::numbers::pi) / blur;
        const double dex = peak * std::exp(-sx * sx / (2 * blur * blur));
        const double dey = peak * std::exp(-sy * sy / (2 * blur * blur));
        const double a = black * light[1];
        Vector J;
        J << -a * (dex * ey * dx_d + ex * dey * dy_d), a * dex * ey * dx_angle, a * ex * dey * dy_angle,
            -a * (dex * ey * sx + ex * dey * sy) / blur, 1, black * ex * ey, d;
        J.head<2>() -= light.tail<2>();
        const double model = light.dot(J.tail<4>());
        const double residual = grey.at<std::uint8_t>(v, u) - model;
        jacobian.col(rows) = J;
        weighted.col(rows) = weight * J;
        residuals[rows++] = residual;
        square += weight * residual * residual;
        weights += weight;
      }
    }
    const Matrix H = weighted.leftCols(rows) * jacobian.leftCols(rows).transpose();
    const Vector g = weighted.leftCols(rows) * residuals.head(rows);
    if (!have_light) {  // first the light alone, which is linear
      light = H.bottomRightCorner<4, 4>().ldlt().solve(g.tail<4>());
      have_light = true;
      if (!(2 * light[1] > kMinContrast / 2)) return std::nullopt;
      continue;
    }
    const Eigen::LDLT<Matrix> factors(H);
    if (factors.info() != Eigen::Success || !factors.isPositive()) return std::nullopt;
    Vector change = factors.solve(g);
    if (!change.allFinite()) return std::nullopt;
    // No step beyond what the linear model can know.
    const double scale = std::min({1.0, 0.3 * radius / std::max(change.head<2>().norm(), 1e-12),
                                   0.3 / std::max(change.segment<2>(2).cwiseAbs().maxCoeff(), 1e-12),
                                   0.4 * blur / std::max(std::abs(change[4]), 1e-12)});
    change *= scale;
    p += change.head<2>();
    x.Rotate(change[2]), y.Rotate(change[3]);
    blur = std::clamp(blur + change[4], 0.2, radius);
    light += change.tail<4>();
    if (!(change.head<2>().norm() < kDone_px)) continue;

    const double variance = square / std::max(weights - kSize, 1.0);
    const double contrast = 2 * light[1];
    if (!(contrast > kMinContrast) || !(std::sqrt(variance) < kMaxMisfit * contrast) ||
        !(std::abs(x.along.dot(y.along)) < 0.94) || !((p - guess.pixel).norm() <= radius / 2)) {
      return std::nullopt;
    }
    const Matrix inverse = factors.solve(Matrix::Identity());
    const Eigen::MatrixXd spread =
        inverse * weighted.leftCols(rows);  // of the pixels' noise to the parameters
    const Matrix covariance = variance * spread * spread.transpose();
    return FittedCorner{p, covariance.topLeftCorner<2, 2>(), blur, contrast};
  }
  return std::nullopt;
}

std::optional<Vector2d> SearchCorner(const cv::Mat& grey, const CornerGuess& guess, double within_px) {
  const Edge x(guess.along_x, guess.along_y, guess.bend_x), y(guess.along_y, guess.along_x, guess.bend_y);
  const double radius = guess.radius_px, black = guess.black_between ? -1 : 1;
  const int reach = static_cast<int>(std::ceil(within_px)), half = static_cast<int>(radius);
  const Vector2d middle = guess.pixel.array().round();
  double best = kMinCorrelation;
  std::optional<Vector2d> found;
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      const Vector2d at = middle + Vector2d(du, dv);
      if (std::hypot(du, dv) > within_px + 0.5 || !Inside(grey, at, radius)) continue;
      double n = 0, s = 0, ss = 0, t = 0, tt = 0, st = 0;
      for (int v = -half; v <= half; ++v) {
        for (int u = -half; u <= half; ++u) {
          const Vector2d d(u, v);
          if (d.norm() > radius) continue;
          Vector2d unused;
          double unused_angle;
          const double soft_x = std::clamp(x.Distance(d, 0, unused, unused_angle), -1.0, 1.0);
          const double soft_y = std::clamp(y.Distance(d, 0, unused, unused_angle), -1.0, 1.0);
          const double form = black * soft_x * soft_y;
          const double value =
              grey.at<std::uint8_t>(static_cast<int>(at.y()) + v, static_cast<int>(at.x()) + u);
          n += 1, s += value, ss += value * value, t += form, tt += form * form, st += value * form;
        }
      }
      const double spread = (ss - s * s / n) * (tt - t * t / n);
      if (!(spread > 0)) continue;
      const double correlation = (st - s * t / n) / std::sqrt(spread);
      if (!(correlation > best)) continue;
      best = correlation;
      found = at;
    }
  }
  return found;
}

}  // namespace kestrel::vision
