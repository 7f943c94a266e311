// SPDX-License-Identifier: Apache-2.0
#include "bench/landmark/bench_homographies.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "base/random.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "vision/landmark/estimation/homography_solutions.h"
#include "vision/landmark/estimation/robust_homography.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Pairs = std::vector<vision::PointPair>;

constexpr int kDraws = 100, kPairs = 100, kFewPairs = 12;
constexpr double kNoise_px =
    0.5;  // of each coordinate of the second image; of both where there are no outliers

Vector2d DrawnPixel(RandomStream& random) {
  const double u = random.Uniform(0, 640), v = random.Uniform(0, 480);
  return {u, v};
}
Vector2d DrawnNoise(RandomStream& random) {
  const double u = random.Normal(), v = random.Normal();
  return kNoise_px * Vector2d(u, v);
}

// Turns, stretches and tilts an image of 640 x 480, and never brings its horizon into it.
Matrix3d DrawnHomography(RandomStream& random) {
  for (;;) {
    Matrix3d H;
    for (int i = 0; i < 9; ++i) H(i / 3, i % 3) = random.Normal();
    const Vector2d tilt = 2e-4 * H.row(2).head<2>().array().tanh();
    H = (Matrix3d() << 1 + 0.2 * H(0, 0), 0.3 * H(0, 1), 80 * H(0, 2), 0.3 * H(1, 0), 1 + 0.2 * H(1, 1),
         80 * H(1, 2), tilt.x(), tilt.y(), 1)
            .finished();
    if (std::abs(H.determinant()) > 0.3) return H;
  }
}

// The mean distance between where both take the corners of the image.
double CornerError(const Matrix3d& H, const Matrix3d& truth) {
  double sum = 0;
  for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(639, 0), Vector2d(639, 479), Vector2d(0, 479)})
    sum += (vision::Transfer(H, corner) - vision::Transfer(truth, corner)).norm() / 4;
  return sum;
}

std::optional<vision::RobustHomography> ByMagsac(const Pairs& pairs) {
  std::vector<cv::Point2d> from, to;
  for (const vision::PointPair& pair : pairs) {
    from.emplace_back(pair.from.x(), pair.from.y());
    to.emplace_back(pair.to.x(), pair.to.y());
  }
  cv::Mat inside;
  const cv::Mat found = cv::findHomography(from, to, cv::USAC_MAGSAC, 2, inside, 2000, 0.999);
  if (found.empty()) return std::nullopt;
  vision::RobustHomography robust{Matrix3d::Identity(), {}, 0};
  cv::cv2eigen(found, robust.H);
  for (int i = 0; i < inside.rows; ++i)
    if (inside.at<uchar>(i)) robust.inliers.push_back(i);
  return robust;
}

struct Estimator {
  const char* name;
  std::function<std::optional<vision::RobustHomography>(const Pairs&)> estimate;
};

const std::vector<Estimator>& Estimators() {
  static const vision::RansacOptions kOptions{.threshold = 2, .confidence = 0.999, .max_trials = 2000};
  static const std::vector<Estimator> kEstimators = {
      {"RANSAC", [](const Pairs& p) { return vision::RansacHomography(p, kOptions); }},
      {"LMedS", [](const Pairs& p) { return vision::LmedsHomography(p, {}); }},
      {"MSAC", [](const Pairs& p) { return vision::MsacHomography(p, kOptions); }},
      {"OpenCV's MAGSAC", ByMagsac}};
  return kEstimators;
}

void BenchRobust(std::uint64_t seed, std::vector<records::Figure>& table) {
  fmt::print("| {:<16} | outliers % | answers % | good pairs kept % | corner px mean 95 % | ms    |\n",
             "estimator");
  for (const Estimator& estimator : Estimators()) {
    for (const int outliers : {0, 20, 40, 49, 60, 70}) {
      RandomStream random(seed, "bench homographies");
      std::vector<double> error, kept, ms;
      for (int draw = 0; draw < kDraws; ++draw) {
        const Matrix3d H = DrawnHomography(random);
        Pairs pairs;
        for (int i = 0; i < kPairs; ++i) {
          const Vector2d from = DrawnPixel(random), other = DrawnPixel(random), noise = DrawnNoise(random);
          pairs.push_back({from, i < outliers ? other : vision::Transfer(H, from) + noise});
        }
        const double start_ms = ThreadCpu_ms();
        const auto found = estimator.estimate(pairs);
        ms.push_back(ThreadCpu_ms() - start_ms);
        if (!found) continue;
        error.push_back(CornerError(found->H, H));
        const auto good =
            std::count_if(found->inliers.begin(), found->inliers.end(), [&](int i) { return i >= outliers; });
        kept.push_back(static_cast<double>(good) / (kPairs - outliers));
      }
      fmt::print("| {:<16} | {:10} | {:9} | {:17.1f} | {:9.2f} {:9.2f} | {:5.2f} |\n", estimator.name,
                 outliers, error.size(), 100 * Mean(kept), Mean(error), Quantile(error, 0.95), Mean(ms));
      if (outliers == 40)
        table.push_back({fmt::format("homography, 40 % outliers, {}: corner error", estimator.name),
                         Mean(error),
                         "px",
                         {},
                         false,
                         ""});
    }
  }
}

void BenchSolutions(std::uint64_t seed, std::vector<records::Figure>& table) {
  using vision::GeometricError;
  struct Solution {
    const char* name;
    std::function<std::optional<Matrix3d>(const Pairs&)> fit;
  };
  const std::vector<Solution> solutions = {
      {"pseudo-inverse", [](const Pairs& p) { return vision::FitInhomogeneous(p); }},
      {"normalised DLT", [](const Pairs& p) { return vision::FitHomography(p); }},
      {"symmetric transfer",
       [](const Pairs& p) { return vision::FitGeometric(p, GeometricError::kSymmetricTransfer); }},
      {"Sampson", [](const Pairs& p) { return vision::FitGeometric(p, GeometricError::kSampson); }}};
  fmt::print("\n| {:<18} | corner px mean | ms    |\n", "solution");
  for (const Solution& solution : solutions) {
    RandomStream random(seed, "bench solutions");
    std::vector<double> error, ms;
    for (int draw = 0; draw < 10 * kDraws; ++draw) {
      const Matrix3d H = DrawnHomography(random);
      Pairs pairs;
      for (int i = 0; i < kFewPairs; ++i) {
        const Vector2d from = DrawnPixel(random), noise_from = DrawnNoise(random),
                       noise_to = DrawnNoise(random);
        pairs.push_back({from + noise_from, vision::Transfer(H, from) + noise_to});
      }
      const double start_ms = ThreadCpu_ms();
      const auto found = solution.fit(pairs);
      ms.push_back(ThreadCpu_ms() - start_ms);
      if (found) error.push_back(CornerError(*found, H));
    }
    fmt::print("| {:<18} | {:14.3f} | {:5.3f} |\n", solution.name, Mean(error), Mean(ms));
    table.push_back({fmt::format("homography of {} pairs, {}: corner error", kFewPairs, solution.name),
                     Mean(error),
                     "px",
                     {},
                     false,
                     ""});
  }
  fmt::print("\n");
}

}  // namespace

void BenchHomographies(std::uint64_t seed, std::vector<records::Figure>& table) {
  BenchRobust(seed, table);
  BenchSolutions(seed, table);
}

}  // namespace kestrel::bench
