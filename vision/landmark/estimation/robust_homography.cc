// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/estimation/robust_homography.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "vision/landmark/estimation/homography_solutions.h"

namespace kestrel::vision {
namespace {

using Pairs = std::span<const PointPair>;
using Matrix3 = Eigen::Matrix3d;

constexpr int kFits = 5;              // of least medians, each to what agrees with the one before
constexpr int kSample = 4;            // s of algorithm 1
constexpr int kOptimisations = 4;     // of a sample that is the best so far
constexpr double kWidest = 3;         // thresholds: the first of them
constexpr double kNoNoise_px = 1e-3;  // exact pairs are inliers within this
constexpr double kMaxSamples = 1e5;

// The squares of the symmetric transfer distances, infinite where they are not numbers.
std::vector<double> Squares(const Matrix3& H, Pairs pairs) {
  const Matrix3 inverse = H.inverse();
  std::vector<double> squares;
  squares.reserve(pairs.size());
  for (const PointPair& pair : pairs) {
    const double square = (Transfer(H, pair.from) - pair.to).squaredNorm() +
                          (Transfer(inverse, pair.to) - pair.from).squaredNorm();
    squares.push_back(std::isfinite(square) ? square : std::numeric_limits<double>::infinity());
  }
  return squares;
}

std::vector<int> Within(const std::vector<double>& squares, double distance) {
  std::vector<int> inside;
  for (int i = 0; i < static_cast<int>(squares.size()); ++i)
    if (squares[i] < distance * distance) inside.push_back(i);
  return inside;
}

std::vector<PointPair> Chosen(Pairs pairs, const std::vector<int>& which) {
  std::vector<PointPair> chosen;
  chosen.reserve(which.size());
  for (const int i : which) chosen.push_back(pairs[i]);
  return chosen;
}

// Homographies of samples of four.
class Samples {
 public:
  Samples(Pairs pairs, std::uint32_t seed)
      : pairs_(pairs), rng_(seed), any_(0, static_cast<int>(pairs.size()) - 1) {}
  std::optional<Matrix3> Next() {
    std::array<int, kSample> pick;
    std::array<PointPair, kSample> sample;
    for (int k = 0; k < kSample; ++k) {
      do pick[k] = any_(rng_);
      while (std::find(pick.begin(), pick.begin() + k, pick[k]) != pick.begin() + k);
      sample[k] = pairs_[pick[k]];
    }
    return FitHomography(sample);
  }

 private:
  Pairs pairs_;
  std::minstd_rand rng_;
  std::uniform_int_distribution<int> any_;
};

// N of algorithm 1: so many samples have one without outliers with the probability that is asked for.
double SamplesFor(double inlier_share, double confidence) {
  const double good = std::pow(inlier_share, kSample);
  const double samples = good < 1 ? std::log(1 - confidence) / std::log(1 - good) : 0;
  return std::clamp(samples, 1.0, kMaxSamples);
}

RobustHomography Result(const Matrix3& H, Pairs pairs, std::vector<int> inliers) {
  RobustHomography result{H, std::move(inliers), 0};
  for (const int i : result.inliers) result.rms += (Transfer(H, pairs[i].from) - pairs[i].to).squaredNorm();
  result.rms = std::sqrt(result.rms / static_cast<double>(result.inliers.size()));
  return result;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Distances in the plane are distributed by Rayleigh: their median is sqrt(2 ln 2) deviations of a coordinate.
// The factor in brackets is that of Rousseeuw and Leroy for few pairs.
double DeviationOf(double median, std::size_t pairs) {
  return median / std::sqrt(2 * std::log(2)) * (1 + 5 / static_cast<double>(pairs - kSample));
}

// The sum of MSAC.
double CostOf(const std::vector<double>& squares, double threshold) {
  double cost = 0;
  for (const double square : squares) cost += std::min(square, threshold * threshold);
  return cost;
}

}  // namespace

std::optional<RobustHomography> LmedsHomography(Pairs pairs, const LmedsOptions& options,
                                                std::uint32_t seed) {
  if (pairs.size() < static_cast<std::size_t>(std::max(kSample + 1, options.min_inliers)))
    return std::nullopt;
  Samples samples(pairs, seed);
  std::optional<Matrix3> best;
  double least = std::numeric_limits<double>::infinity();
  const double trials = SamplesFor(1 - options.outliers, options.confidence);
  for (int trial = 0; trial < trials; ++trial) {
    const auto H = samples.Next();
    if (!H) continue;
    const double median = Median(Squares(*H, pairs));
    if (median < least) least = median, best = H;
  }
  if (!best || !(std::sqrt(least) < options.max_median_px)) return std::nullopt;
  const double bound = std::max(3 * DeviationOf(std::sqrt(least), pairs.size()), kNoNoise_px);
  std::vector<int> inliers = Within(Squares(*best, pairs), bound);
  for (int pass = 1;; ++pass) {  // the sample's own noise is in the first
    if (static_cast<int>(inliers.size()) < options.min_inliers) return std::nullopt;
    const auto H = FitHomography(Chosen(pairs, inliers));
    if (!H) return std::nullopt;
    if (pass == kFits) return Result(*H, pairs, std::move(inliers));
    const std::vector<double> squares = Squares(*H, pairs);
    inliers =
        Within(squares, std::max(3 * DeviationOf(std::sqrt(Median(squares)), pairs.size()), kNoNoise_px));
  }
}

std::optional<RobustHomography> MsacHomography(Pairs pairs, const RansacOptions& options,
                                               std::uint32_t seed) {
  const int n = static_cast<int>(pairs.size());
  if (n < std::max(kSample, options.min_inliers)) return std::nullopt;
  Samples samples(pairs, seed);
  std::optional<Matrix3> best;
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](const Matrix3& H, const std::vector<double>& squares) {
    const double cost = CostOf(squares, options.threshold);
    if (!(cost < least)) return false;
    least = cost, best = H;
    return true;
  };
  double needed = options.max_trials;
  for (int trial = 0; trial < needed && trial < options.max_trials; ++trial) {
    const auto H = samples.Next();
    if (!H) continue;
    std::vector<double> squares = Squares(*H, pairs);
    if (!take(*H, squares)) continue;
    for (int k = 0; k < kOptimisations; ++k) {
      const double widening = kWidest + (1 - kWidest) * k / (kOptimisations - 1);
      const auto again = FitHomography(Chosen(pairs, Within(squares, widening * options.threshold)));
      if (!again) break;
      squares = Squares(*again, pairs);
      take(*again, squares);
    }
    const auto inliers = Within(Squares(*best, pairs), options.threshold).size();
    needed = SamplesFor(static_cast<double>(inliers) / n, options.confidence);
  }
  if (!best) return std::nullopt;
  for (int pass = 0;; ++pass) {
    std::vector<int> inliers = Within(Squares(*best, pairs), options.threshold);
    if (static_cast<int>(inliers.size()) < std::max(kSample, options.min_inliers)) return std::nullopt;
    best = FitGeometric(Chosen(pairs, inliers), GeometricError::kSymmetricTransfer);
    if (!best) return std::nullopt;
    if (pass == 1) return Result(*best, pairs, std::move(inliers));
  }
}

}  // namespace kestrel::vision
