// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/motion_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// Of pairs about their centroids: with a scale or without. In the plane both have a closed form.
std::optional<Matrix3d> FitTurn(std::span<const PointPair> pairs, bool with_scale) {
  Vector2d from = Vector2d::Zero(), to = Vector2d::Zero();
  for (const PointPair& pair : pairs) from += pair.from, to += pair.to;
  from /= static_cast<double>(pairs.size()), to /= static_cast<double>(pairs.size());
  double along = 0, across = 0, spread = 0;
  for (const PointPair& pair : pairs) {
    const Vector2d a = pair.from - from, b = pair.to - to;
    along += a.dot(b);
    across += a.x() * b.y() - a.y() * b.x();
    spread += a.squaredNorm();
  }
  const double length = std::hypot(along, across);
  if (!(spread > 1e-9) || !(length > 1e-12 * spread)) return std::nullopt;
  const double scale = with_scale ? length / spread : 1, c = scale * along / length,
               s = scale * across / length;
  Matrix3d H;
  H << c, -s, to.x() - c * from.x() + s * from.y(), s, c, to.y() - s * from.x() - c * from.y(), 0, 0, 1;
  return H;
}

std::optional<Matrix3d> FitAffine(std::span<const PointPair> pairs) {
  Vector2d from = Vector2d::Zero(), to = Vector2d::Zero();
  for (const PointPair& pair : pairs) from += pair.from, to += pair.to;
  from /= static_cast<double>(pairs.size()), to /= static_cast<double>(pairs.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero(), both = Eigen::Matrix2d::Zero();
  for (const PointPair& pair : pairs) {
    spread += (pair.from - from) * (pair.from - from).transpose();
    both += (pair.to - to) * (pair.from - from).transpose();
  }
  if (!(spread.determinant() > 1e-9 * spread.trace() * spread.trace()) || !(spread.trace() > 1e-9))
    return std::nullopt;
  const Eigen::Matrix2d A = both * spread.inverse();
  Matrix3d H = Matrix3d::Identity();
  H.topLeftCorner<2, 2>() = A;
  H.topRightCorner<2, 1>() = to - A * from;
  return H;
}

void FindInliers(std::span<const PointPair> pairs, const Matrix3d& H, double threshold_px,
                 std::vector<int>& inliers) {
  inliers.clear();
  for (int i = 0; i < static_cast<int>(pairs.size()); ++i)
    if ((Transfer(H, pairs[static_cast<std::size_t>(i)].from) - pairs[static_cast<std::size_t>(i)].to)
            .squaredNorm() < threshold_px * threshold_px)
      inliers.push_back(i);
}

}  // namespace

const std::vector<std::string>& MotionModelNames() {
  static const std::vector<std::string> names = {"euclidean", "similarity", "affine", "homography"};
  return names;
}

std::optional<MotionModel> MotionModelNamed(const std::string& name) {
  const auto& names = MotionModelNames();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  return static_cast<MotionModel>(at - names.begin());
}

const std::string& NameOf(MotionModel model) { return MotionModelNames()[static_cast<std::size_t>(model)]; }

int MinPairs(MotionModel model) {
  return model == MotionModel::kHomography ? 4 : model == MotionModel::kAffine ? 3 : 2;
}

std::optional<Matrix3d> FitMotion(std::span<const PointPair> pairs, MotionModel model) {
  if (static_cast<int>(pairs.size()) < MinPairs(model)) return std::nullopt;
  switch (model) {
    case MotionModel::kEuclidean:
      return FitTurn(pairs, false);
    case MotionModel::kSimilarity:
      return FitTurn(pairs, true);
    case MotionModel::kAffine:
      return FitAffine(pairs);
    case MotionModel::kHomography:
      break;
  }
  const auto H = FitHomography(pairs);
  if (!H || std::abs((*H)(2, 2)) < 1e-12) return std::nullopt;
  return *H / (*H)(2, 2);
}

std::optional<RobustMotion> FitRobustMotion(std::span<const PointPair> pairs, MotionModel model,
                                            const RobustMotionOptions& options) {
  const int least = std::max(options.min_inliers, MinPairs(model));
  if (static_cast<int>(pairs.size()) < least) return std::nullopt;
  const auto size = static_cast<std::size_t>(MinPairs(model));
  std::array<PointPair, 4> sample;
  std::array<std::size_t, 4> pick{};
  std::vector<int> best, inliers;
  std::vector<PointPair> chosen;
  const auto fit = [&](const std::vector<int>& of) {
    chosen.clear();
    for (const int i : of) chosen.push_back(pairs[static_cast<std::size_t>(i)]);
    return FitMotion(chosen, model);
  };
  SampleSequence any;
  double needed = options.max_trials;
  for (int trial = 0; trial < needed && trial < options.max_trials; ++trial) {
    for (std::size_t k = 0; k < size; ++k) {
      do pick[k] = any.Next(pairs.size());
      while (std::find(pick.begin(), pick.begin() + static_cast<std::ptrdiff_t>(k), pick[k]) !=
             pick.begin() + static_cast<std::ptrdiff_t>(k));
      sample[k] = pairs[pick[k]];
    }
    const auto H = FitMotion(std::span(sample).first(size), model);
    if (!H) continue;
    FindInliers(pairs, *H, options.threshold_px, inliers);
    if (inliers.size() <= best.size()) continue;
    // A sample of noisy pairs bends off far from itself; a fit to what agrees gathers the rest.
    best = inliers;
    if (const auto again = fit(best)) {
      FindInliers(pairs, *again, options.threshold_px, inliers);
      if (inliers.size() > best.size()) best = inliers;
    }
    const double good = std::pow(static_cast<double>(best.size()) / static_cast<double>(pairs.size()),
                                 static_cast<double>(size));
    needed = good < 1 ? std::log(1 - options.confidence) / std::log1p(-good) : 0;
  }
  std::optional<Matrix3d> H;
  for (int pass = 0; pass < 2; ++pass) {
    if (static_cast<int>(best.size()) < least) return std::nullopt;
    H = fit(best);
    if (!H) return std::nullopt;
    if (pass == 0) FindInliers(pairs, *H, options.threshold_px, best);
  }
  RobustMotion result{*H, best, 0};
  for (const int i : best) {
    const PointPair& pair = pairs[static_cast<std::size_t>(i)];
    result.rms_px += (Transfer(*H, pair.from) - pair.to).squaredNorm();
  }
  result.rms_px = std::sqrt(result.rms_px / static_cast<double>(best.size()));
  return result;
}

}  // namespace kestrel::vision
