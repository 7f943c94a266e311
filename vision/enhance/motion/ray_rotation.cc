// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/ray_rotation.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"

namespace kestrel::vision {
namespace {

std::vector<int> InliersOf(std::span<const RayPair> pairs, const Eigen::Quaterniond& R, double threshold) {
  const Eigen::Matrix3d turn = R.toRotationMatrix();
  const double most = 2 * std::sin(threshold / 2);  // chord
  std::vector<int> inliers;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if ((turn * pairs[i].from - pairs[i].to).squaredNorm() < most * most)
      inliers.push_back(static_cast<int>(i));
  return inliers;
}

std::optional<Eigen::Quaterniond> FitTo(std::span<const RayPair> pairs, const std::vector<int>& of) {
  std::vector<RayPair> chosen;
  for (const int i : of) chosen.push_back(pairs[static_cast<std::size_t>(i)]);
  return FitRotation(chosen);
}

}  // namespace

std::optional<Eigen::Quaterniond> FitRotation(std::span<const RayPair> pairs) {
  if (pairs.size() < 2) return std::nullopt;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const RayPair& pair : pairs) sum += pair.to * pair.from.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(1) > 1e-9 * svd.singularValues()(0))) return std::nullopt;
  const Eigen::Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  const Eigen::Matrix3d R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  return Eigen::Quaterniond(R).normalized();
}

std::optional<RobustRotation> FitRobustRotation(std::span<const RayPair> pairs, double threshold,
                                                int min_inliers) {
  if (static_cast<int>(pairs.size()) < std::max(2, min_inliers)) return std::nullopt;
  constexpr int kMaxTrials = 200;
  constexpr double kConfidence = 0.999;
  SampleSequence any;
  std::vector<int> best;
  double needed = kMaxTrials;
  for (int trial = 0; trial < needed && trial < kMaxTrials; ++trial) {
    const std::size_t a = any.Next(pairs.size()), b = any.Next(pairs.size());
    if (a == b) continue;
    const auto R = FitRotation(std::array{pairs[a], pairs[b]});
    if (!R) continue;
    std::vector<int> inliers = InliersOf(pairs, *R, threshold);
    if (inliers.size() <= best.size()) continue;
    best = std::move(inliers);
    const double good = std::pow(static_cast<double>(best.size()) / static_cast<double>(pairs.size()), 2);
    needed = good < 1 ? std::log(1 - kConfidence) / std::log1p(-good) : 0;
  }
  std::optional<Eigen::Quaterniond> R;
  for (int pass = 0; pass < 2; ++pass) {
    if (static_cast<int>(best.size()) < min_inliers) return std::nullopt;
    R = FitTo(pairs, best);
    if (!R) return std::nullopt;
    if (pass == 0) best = InliersOf(pairs, *R, threshold);
  }
  return RobustRotation{*R, best};
}

}  // namespace kestrel::vision
