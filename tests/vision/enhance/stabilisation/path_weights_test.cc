// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/path_weights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kestrel::vision {
namespace {

constexpr int kBefore = 75, kAfter = 30;
constexpr double kCutoff = 1 / 75.0;

// What the weights leave of a wave at the place that is asked for, of any phase.
double Gain(const Eigen::VectorXd& weights, double frequency) {
  double cosine = 0, sine = 0;
  for (int k = 0; k < weights.size(); ++k) {
    cosine += weights(k) * std::cos(2 * std::numbers::pi * frequency * k);
    sine += weights(k) * std::sin(2 * std::numbers::pi * frequency * k);
  }
  return std::hypot(cosine, sine);
}

TEST(PathWeights, LeaveAnEvenPathAsItIsWhereverThePlacesEnd) {
  PathWeights weights(kBefore, kAfter, kCutoff);
  for (const int before : {0, 1, 5, kBefore}) {
    for (const int after : {0, 1, 12, kAfter}) {
      const Eigen::VectorXd of = weights.Of(before, after);
      ASSERT_EQ(of.size(), before + after + 1);
      EXPECT_NEAR(of.sum(), 1, 1e-6);
      if (of.size() == 1) continue;
      EXPECT_NEAR(of.dot(Eigen::VectorXd::LinSpaced(of.size(), -before, after)), 0, 1e-4);
    }
  }
}

TEST(PathWeights, KeepLittleOfShakesAndMuchOfAPath) {
  PathWeights weights(kBefore, kAfter, kCutoff);
  const Eigen::VectorXd of = weights.Of(kBefore, kAfter);
  for (const double times : {3.0, 5.0, 10.0, 30.0}) EXPECT_LT(Gain(of, times * kCutoff), 0.05) << times;
  EXPECT_NEAR(Gain(of, 0.2 * kCutoff), 1, 0.1);
}

// The least mean square error: what is wanted and what comes differ by nothing that the places know, so that no change
// of the weights which leaves even paths as they are makes the error smaller. Its spectra are those of the definition.
TEST(PathWeights, AreOfTheLeastMeanSquareError) {
  PathWeights weights(kBefore, kAfter, kCutoff);
  const auto error = [](const Eigen::VectorXd& of) {
    double sum = 0;
    constexpr int kSteps = 3000;
    for (int i = 0; i < kSteps; ++i) {
      const double f = 0.5 * (i + 0.5) / kSteps;
      double re = 0, im = 0;
      for (int k = 0; k < of.size(); ++k) {
        re += of(k) * std::cos(2 * std::numbers::pi * f * (k - kBefore));
        im += of(k) * std::sin(2 * std::numbers::pi * f * (k - kBefore));
      }
      const double path =
          std::pow(std::sin(std::numbers::pi * kCutoff) / 2 / std::sin(std::numbers::pi * f), 4);
      sum +=
          ((re - 1) * (re - 1) + im * im) * path + (re * re + im * im) * ((f < 2.5 * kCutoff ? 0 : 1) + 1e-3);
    }
    return sum / kSteps;
  };
  const Eigen::VectorXd of = weights.Of(kBefore, kAfter);
  const double least = error(of);
  for (const int place : {0, 20, 60, 90}) {
    for (const double sign : {-1.0, 1.0}) {
      Eigen::VectorXd other = of;
      other.segment(place, 3) += sign * 3e-3 * Eigen::Vector3d(1, -2, 1);
      EXPECT_GT(error(other), least) << place;
    }
  }
}

// A path of which the places come one by one is as smooth as one of the whole window.
TEST(PathWeights, ABeginningIsNoJolt) {
  PathWeights weights(kBefore, kAfter, kCutoff);
  const auto shake = [](int k) { return std::sin(2 * std::numbers::pi * 4 * kCutoff * k + 1); };
  double before = 0, last = 0, jolt = 0;
  for (int k = 0; k < 2 * kBefore; ++k) {
    const int known = std::min(k, kBefore);
    const Eigen::VectorXd& of = weights.Of(known, kAfter);
    double path = 0;
    for (int i = 0; i < of.size(); ++i) path += of(i) * shake(k - known + i);
    if (k > 1) jolt = std::max(jolt, std::abs(path - 2 * last + before));
    before = last, last = path;
  }
  const double of_shake = std::pow(2 * std::numbers::pi * 4 * kCutoff, 2);  // its own second difference
  EXPECT_LT(jolt, 0.1 * of_shake);
}

}  // namespace
}  // namespace kestrel::vision
