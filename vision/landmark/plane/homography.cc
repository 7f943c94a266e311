// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/plane/homography.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <random>

namespace kestrel::vision {
namespace {

// Moves the centroid to the origin and the mean distance to sqrt(2).
Eigen::Matrix3d Normaliser(std::span<const PointPair> pairs, Eigen::Vector2d PointPair::*side) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const PointPair& pair : pairs) centre += pair.*side;
  centre /= static_cast<double>(pairs.size());
  double distance = 0;
  for (const PointPair& pair : pairs) distance += (pair.*side - centre).norm();
  distance /= static_cast<double>(pairs.size());
  const double s = distance > 0 ? std::sqrt(2.0) / distance : 1;
  Eigen::Matrix3d n;
  n << s, 0, -s * centre.x(), 0, s, -s * centre.y(), 0, 0, 1;
  return n;
}

std::optional<Eigen::Matrix3d> Finish(const Eigen::Matrix3d& normalised, const Eigen::Matrix3d& n_from,
                                      const Eigen::Matrix3d& n_to) {
  Eigen::Matrix3d H = n_to.inverse() * normalised * n_from;
  H /= H.norm();
  if (!H.allFinite() || std::abs(H.determinant()) < 1e-15) return std::nullopt;
  return H;
}

// Three of four points on one line leave the system without a unique solution, which rounding would hide.
bool AnyThreeCollinear(const std::array<Eigen::Vector2d, 4>& p) {
  for (int skip = 0; skip < 4; ++skip) {
    const Eigen::Vector2d a = p[(skip + 2) % 4] - p[(skip + 1) % 4],
                          b = p[(skip + 3) % 4] - p[(skip + 1) % 4];
    if (!(std::abs(a.x() * b.y() - a.y() * b.x()) > 1e-6)) return true;
  }
  return false;
}

// eq. (3.15) with the centroid at the origin: h33 is the denominator at the centroid, which a plane in front
// of the camera never makes zero.
std::optional<Eigen::Matrix3d> FitFour(std::span<const PointPair> pairs) {
  const Eigen::Matrix3d n_from = Normaliser(pairs, &PointPair::from),
                        n_to = Normaliser(pairs, &PointPair::to);
  std::array<Eigen::Vector2d, 4> from, to;
  for (int i = 0; i < 4; ++i) {
    from[i] = Transfer(n_from, pairs[i].from);
    to[i] = Transfer(n_to, pairs[i].to);
  }
  if (AnyThreeCollinear(from) || AnyThreeCollinear(to)) return std::nullopt;
  Eigen::Matrix<double, 8, 8> A;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d &x = from[i], &y = to[i];
    A.row(2 * i) << x.x(), x.y(), 1, 0, 0, 0, -x.x() * y.x(), -x.y() * y.x();
    A.row(2 * i + 1) << 0, 0, 0, x.x(), x.y(), 1, -x.x() * y.y(), -x.y() * y.y();
    b.segment<2>(2 * i) = y;
  }
  const Eigen::Matrix<double, 8, 1> h = A.partialPivLu().solve(b);
  Eigen::Matrix3d normalised;
  normalised << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), 1;
  if (!normalised.allFinite() || normalised.norm() > 1e4) return std::nullopt;
  return Finish(normalised, n_from, n_to);
}

// By the symmetric transfer distance squared: d(x', Hx)^2 + d(x, H^-1 x')^2.
std::vector<int> InliersOf(const Eigen::Matrix3d& H, std::span<const PointPair> pairs, double threshold) {
  const Eigen::Matrix3d H_inverse = H.inverse();
  const double most = threshold * threshold;
  std::vector<int> inliers;
  for (int i = 0; i < static_cast<int>(pairs.size()); ++i) {
    const PointPair& pair = pairs[i];
    // Written so that NaN is an outlier. Of most outliers the first part says it.
    const double forth = (Transfer(H, pair.from) - pair.to).squaredNorm();
    if (!(forth < most)) continue;
    if (forth + (Transfer(H_inverse, pair.to) - pair.from).squaredNorm() < most) inliers.push_back(i);
  }
  return inliers;
}

std::optional<Eigen::Matrix3d> FitTo(std::span<const PointPair> pairs, const std::vector<int>& inliers) {
  std::vector<PointPair> chosen;
  chosen.reserve(inliers.size());
  for (const int i : inliers) chosen.push_back(pairs[i]);
  return FitHomography(chosen);
}

}  // namespace

Eigen::Vector2d Transfer(const Eigen::Matrix3d& H, const Eigen::Vector2d& x) {
  return (H * x.homogeneous()).hnormalized();
}

std::optional<Eigen::Matrix3d> FitHomography(std::span<const PointPair> pairs) {
  if (pairs.size() < 4) return std::nullopt;
  if (pairs.size() == 4) return FitFour(pairs);
  const Eigen::Matrix3d n_from = Normaliser(pairs, &PointPair::from),
                        n_to = Normaliser(pairs, &PointPair::to);
  // The 9x9 normal matrix of eq. (3.14): after the normalisation its condition is that of the problem.
  Eigen::Matrix<double, 9, 9> AtA = Eigen::Matrix<double, 9, 9>::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d x = Transfer(n_from, pair.from), y = Transfer(n_to, pair.to);
    Eigen::Matrix<double, 2, 9> A;
    A.row(0) << x.x(), x.y(), 1, 0, 0, 0, -x.x() * y.x(), -x.y() * y.x(), -y.x();
    A.row(1) << 0, 0, 0, x.x(), x.y(), 1, -x.x() * y.y(), -x.y() * y.y(), -y.y();
    AtA.noalias() += A.transpose() * A;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(AtA);
  // A second vanishing eigenvalue: the points do not fix the homography (collinear, or too few distinct
  // ones).
  if (!(solver.eigenvalues()(1) > 1e-12 * solver.eigenvalues()(8))) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  Eigen::Matrix3d normalised;
  normalised << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  return Finish(normalised, n_from, n_to);
}

std::optional<RobustHomography> RansacHomography(std::span<const PointPair> pairs,
                                                 const RansacOptions& options, std::uint32_t seed) {
  const int n = static_cast<int>(pairs.size());
  if (n < std::max(4, options.min_inliers)) return std::nullopt;
  std::minstd_rand rng(seed);
  std::uniform_int_distribution<int> any(0, n - 1);
  std::vector<int> best;
  double needed = options.max_trials;
  for (int trial = 0; trial < needed && trial < options.max_trials; ++trial) {
    std::array<int, 4> pick;
    for (int k = 0; k < 4; ++k) {
      do pick[k] = any(rng);
      while (std::find(pick.begin(), pick.begin() + k, pick[k]) != pick.begin() + k);
    }
    const std::array<PointPair, 4> sample = {pairs[pick[0]], pairs[pick[1]], pairs[pick[2]], pairs[pick[3]]};
    const auto H = FitFour(sample);
    if (!H) continue;
    std::vector<int> inliers = InliersOf(*H, pairs, options.threshold);
    if (inliers.size() <= best.size()) continue;
    best = std::move(inliers);
    const double good = std::pow(static_cast<double>(best.size()) / n, 4);  // (1 - epsilon)^s
    needed = good < 1 ? std::log(1 - options.confidence) / std::log(1 - good) : 0;
  }
  for (int pass = 0; pass < 2; ++pass) {
    if (static_cast<int>(best.size()) < options.min_inliers) return std::nullopt;
    const auto H = FitTo(pairs, best);
    if (!H) return std::nullopt;
    if (pass == 0) {
      best = InliersOf(*H, pairs, options.threshold);
      continue;
    }
    RobustHomography result{*H, best, 0};
    for (const int i : best) result.rms += (Transfer(*H, pairs[i].from) - pairs[i].to).squaredNorm();
    result.rms = std::sqrt(result.rms / static_cast<double>(best.size()));
    return result;
  }
  return std::nullopt;
}

}  // namespace kestrel::vision
