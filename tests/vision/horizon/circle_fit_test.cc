// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/circle_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/tait_bryan.h"
#include "vision/horizon/border/skyline_fix.h"

namespace kestrel::vision {
namespace {

// The circle at a dip about "down", in the frame of the points.
std::vector<Eigen::Vector3d> CirclePoints(const Eigen::Vector3d& down, double dip, int n) {
  const Eigen::Vector3d u = down.unitOrthogonal(), v = down.cross(u);
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * M_PI * i / n;
    out.push_back(std::cos(dip) * (std::cos(a) * u + std::sin(a) * v) + std::sin(dip) * down);
  }
  return out;
}

std::vector<ContourPoint> Contour(const Eigen::Vector3d& state, double noise, int seed) {
  std::mt19937 draw(static_cast<unsigned>(seed));
  std::normal_distribution<double> normal;
  std::vector<ContourPoint> out;
  for (int i = 0; i < 240; ++i) {
    const double a = 2 * M_PI * i / 240;
    out.push_back({a, state[0] * std::cos(a) + state[1] * std::sin(a) + state[2] + noise * normal(draw), 1});
  }
  return out;
}

TEST(RollPitchFromDown, GivesBackTheAnglesOfTheRotationMatrixAndZeroWhenLevel) {
  int checked = 0;
  for (const double yaw : {-2.5, 0.3})
    for (const double pitch : {-1.2, -0.4, 0.0, 0.7})
      for (const double roll : {-2.0, -0.5, 0.0, 1.1}) {
        const Eigen::Matrix3d R_NB = RotationFromTaitBryan({yaw, pitch, roll});
        const RollPitch angles = RollPitchFromDown(R_NB.transpose() * Eigen::Vector3d::UnitZ());
        EXPECT_NEAR(angles.roll, roll, 1e-12);
        EXPECT_NEAR(angles.pitch, pitch, 1e-12);
        ++checked;
      }
  EXPECT_EQ(checked, 32);
}

TEST(RollPitchFromDown, ItsCovarianceIsThatOfSmallChangesOfDown) {
  const Eigen::Vector3d down = (RotationFromTaitBryan({0.2, 0.5, -0.7}).transpose()).col(2);
  Eigen::Matrix3d S = Eigen::Vector3d(1e-4, 4e-4, 2e-4).asDiagonal();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - down * down.transpose();
  S = across * S * across;
  Eigen::Matrix<double, 2, 3> J;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = 1e-6 * across.col(k);
    const RollPitch high = RollPitchFromDown((down + step).normalized());
    const RollPitch low = RollPitchFromDown((down - step).normalized());
    J(0, k) = (high.roll - low.roll) / 2e-6;
    J(1, k) = (high.pitch - low.pitch) / 2e-6;
  }
  EXPECT_LT((RollPitchFromDown(down, S).covariance - J * S * J.transpose()).norm(), 1e-9);
}

TEST(FitPlane, Equation615IsThePlaneOfTheSmallestSingularVectorOnCleanPoints) {
  int checked = 0;
  for (const double tilt : {0.0, 0.3, 0.8}) {
    const Eigen::Vector3d down(std::sin(tilt) * 0.6, -std::sin(tilt) * 0.8, std::cos(tilt));
    const auto points = CirclePoints(down, 0.02, 90);
    const auto plane = FitPlane(points);
    ASSERT_TRUE(plane);
    EXPECT_LT((plane->Down() - down).norm(), 1e-9);
    // The other way: the direction in which the points, about their mean, do not spread.
    Eigen::MatrixX3d A(90, 3);
    for (int i = 0; i < 90; ++i) A.row(i) = points[static_cast<std::size_t>(i)];
    A.rowwise() -= A.colwise().mean().eval();
    const Eigen::JacobiSVD<Eigen::MatrixX3d> svd(A, Eigen::ComputeFullV);
    EXPECT_GT(std::abs(svd.matrixV().col(2).dot(plane->Down())), 1 - 1e-9);
    ++checked;
  }
  EXPECT_EQ(checked, 3);
  EXPECT_FALSE(FitPlane({Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(0, 0, 0)}));
}

TEST(FitCircle, OnACleanContourItIsTheLeastSquaresFit) {
  const Eigen::Vector3d truth(0.01, -0.02, -0.006);
  const auto contour = Contour(truth, 2e-4, 3);
  Eigen::MatrixX3d A(240, 3);
  Eigen::VectorXd b(240);
  for (int i = 0; i < 240; ++i) {
    const auto& p = contour[static_cast<std::size_t>(i)];
    A.row(i) << std::cos(p.azimuth), std::sin(p.azimuth), 1;
    b[i] = p.elevation;
  }
  const Eigen::Vector3d closed = A.colPivHouseholderQr().solve(b);
  const auto fit = FitCircle(contour);
  ASSERT_TRUE(fit);
  // What lies a little above the circle might be a hill: a third of the scatter between the two.
  EXPECT_LT((fit->state - closed).head<2>().norm(), 3e-5);
  EXPECT_NEAR(fit->state[2], closed[2], 2e-4);
  EXPECT_GT(fit->on_circle, 0.99);
}

TEST(FitCircle, ARidgeOverTwoFifthsAndTreesDoNotLiftItAndTheDeviationSaysSo) {
  const Eigen::Vector3d truth(0.02, 0.01, -0.005);
  auto contour = Contour(truth, 5e-4, 4);
  const auto clean = FitCircle(contour);
  for (std::size_t i = 30; i < 126; ++i)
    contour[i].elevation += 0.17 + 0.01 * std::sin(0.7 * static_cast<double>(i));
  for (std::size_t i = 130; i < 230; i += 9) contour[i].elevation += 0.06;
  const auto fit = FitCircle(contour);
  ASSERT_TRUE(clean && fit);
  EXPECT_LT((fit->state - truth).head<2>().norm(), Radians(0.15));
  EXPECT_GT(fit->covariance(0, 0) + fit->covariance(1, 1),
            4 * (clean->covariance(0, 0) + clean->covariance(1, 1)));
}

TEST(FitCircle, AShortArcsDeviationHoldsForWhatLiftsOrTiltsAllOfIt) {
  // Contours over 80 degrees, off by a random walk back to 0: 0.5 degrees, alike over 40 degrees.
  std::mt19937 draw(5);
  std::normal_distribution<double> normal;
  const double step = 2 * M_PI / 240, off = Radians(0.5), back = std::exp(-step / 0.7);
  CircleFitOptions plain, arc;
  arc.arc_relief = off;
  int within_plain = 0, within_arc = 0;
  constexpr int kContours = 60;
  for (int k = 0; k < kContours; ++k) {
    std::vector<ContourPoint> contour;
    double lift = off * normal(draw);
    for (int i = -27; i <= 27; ++i) {
      contour.push_back({i * step + (i < 0 ? 2 * M_PI : 0), lift - plain.dip, 1});
      lift = back * lift + std::sqrt(1 - back * back) * off * normal(draw);
    }
    std::rotate(contour.begin(), contour.begin() + 27, contour.end());
    for (const CircleFitOptions& options : {plain, arc}) {
      const auto fit = FitCircle(contour, options);
      ASSERT_TRUE(fit);
      for (int axis = 0; axis < 2; ++axis)
        (options.arc_relief > 0 ? within_arc : within_plain) +=
            std::abs(fit->state[axis]) < 2 * std::sqrt(fit->covariance(axis, axis));
    }
  }
  EXPECT_LT(within_plain, 0.85 * 2 * kContours);
  EXPECT_GT(within_arc, 0.90 * 2 * kContours);
}

TEST(FitCircle, AShortArcIsLessSureThanTheWholeCircle) {
  const auto whole = Contour({0, 0, -0.005}, 5e-4, 5);
  const std::vector<ContourPoint> arc(whole.begin(), whole.begin() + 50);
  const auto all = FitCircle(whole), some = FitCircle(arc);
  ASSERT_TRUE(all && some);
  EXPECT_GT(some->covariance(0, 0), 4 * all->covariance(0, 0));
  EXPECT_FALSE(FitCircle({whole.begin(), whole.begin() + 7}));
}

}  // namespace
}  // namespace kestrel::vision
