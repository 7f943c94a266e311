// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/estimation/plane_pnp.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const Pinhole kCamera{640, 480, 810, 790, 290, 255};

class Random {
 public:
  explicit Random(unsigned seed) : rng_(seed) {}
  double Normal() { return normal_(rng_); }
  double Uniform(double low, double high) { return low + (high - low) * unit_(rng_); }
  Pose PadPose(double tilt) {
    const double azimuth = Uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Quaterniond R_CT = ExpRotation(tilt * Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) *
                                    ExpRotation({0, 0, Uniform(-std::numbers::pi, std::numbers::pi)});
    const Vector3d ray = *kCamera.Ray({Uniform(150, 490), Uniform(120, 360)});
    return {R_CT, Uniform(2, 8) / ray.z() * ray};
  }

 private:
  std::mt19937 rng_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_;
};

std::vector<PointPair> Grid(const Pose& X_CT, Random* noise = nullptr, double sigma = 0) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < 5; ++i) {
    for (int k = 0; k < 5; ++k) {
      const Vector2d on_pad(1.19 * (i / 4.0 - 0.5), 0.91 * (k / 4.0 - 0.5));
      pairs.push_back({on_pad, kCamera.Project(X_CT * Vector3d(on_pad.x(), on_pad.y(), 0)).value()});
      if (noise) pairs.back().to += Vector2d(sigma * noise->Normal(), sigma * noise->Normal());
    }
  }
  return pairs;
}

Vector6 Between(const Pose& from, const Pose& to) {
  Vector6 d;
  d << to.p - from.p, LogRotation(to.R * from.R.conjugate());
  return d;
}

TEST(PlanePnp, ExactPixelsGiveThePoseBack) {
  Random random(41);
  for (int i = 0; i < 40; ++i) {
    const Pose X_CT = random.PadPose(random.Uniform(0, 1.2));
    const std::vector<PointPair> pairs = Grid(X_CT);
    const auto ippe = IppePoses(pairs, kCamera, 0.1);
    ASSERT_FALSE(ippe.empty()) << i;
    EXPECT_LT(Between(X_CT, ippe[0].X_CT).norm(), 1e-4) << i;
    const auto sqpnp = SqpnpPose(pairs, kCamera, 0.1);
    ASSERT_TRUE(sqpnp) << i;
    EXPECT_LT(Between(X_CT, sqpnp->X_CT).norm(), 1e-4) << i;
    const auto likely = MostLikelyPlanePose(pairs, kCamera, 0.1);
    ASSERT_TRUE(likely) << i;
    EXPECT_LT(Between(X_CT, likely->X_CT).norm(), 1e-7) << i;
  }
}

// The second pose is about the first, mirrored at the plane square to the view: both look alike from afar alone.
TEST(IppePoses, GiveBothPosesAndTellByTheirErrorsHowAmbiguousTheViewIs) {
  Random random(42);
  int both = 0, ambiguous = 0;
  for (int i = 0; i < 30; ++i) {
    Pose X_CT = random.PadPose(0.6);
    X_CT.p *= 3 / X_CT.p.norm();
    const auto near = IppePoses(Grid(X_CT, &random, 0.2), kCamera, 0.2);
    X_CT.p *= 10;
    const auto far = IppePoses(Grid(X_CT, &random, 0.2), kCamera, 0.2);
    if (near.size() < 2 || far.size() < 2) continue;
    ++both;
    EXPECT_LE(near[0].rms_px, near[1].rms_px);
    EXPECT_GT(near[1].rms_px, 3 * near[0].rms_px) << i;
    ambiguous += far[1].rms_px < 1.5 * far[0].rms_px;
    EXPECT_GT(LogRotation(far[1].X_CT.R * far[0].X_CT.R.conjugate()).norm(), 0.5) << i;
  }
  EXPECT_GE(both, 28);
  EXPECT_GE(ambiguous, 27);  // noise tells them apart now and then
}

TEST(MostLikelyPlanePose, HasTheLeastReprojectionError) {
  Random random(43);
  int cases = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose X_CT = random.PadPose(random.Uniform(0.1, 1.2));
    const std::vector<PointPair> pairs = Grid(X_CT, &random, 0.3);
    const auto likely = MostLikelyPlanePose(pairs, kCamera, 0.3);
    ASSERT_TRUE(likely);
    for (const PlanePose& pose : IppePoses(pairs, kCamera, 0.3))
      EXPECT_LE(likely->rms_px, pose.rms_px + 1e-9);
    const auto sqpnp = SqpnpPose(pairs, kCamera, 0.3);
    ASSERT_TRUE(sqpnp);
    EXPECT_LE(likely->rms_px, sqpnp->rms_px + 1e-9);
    const auto from_truth = RefinePlanePose(pairs, kCamera, X_CT, 0.3);
    ASSERT_TRUE(from_truth);
    EXPECT_LE(likely->rms_px, from_truth->rms_px + 1e-9);
    ++cases;
  }
  EXPECT_EQ(cases, 40);
}

TEST(PoseInformation, IsThatOfTheNumericDerivative) {
  Random random(44);
  for (int i = 0; i < 20; ++i) {
    const Pose X_CT = random.PadPose(random.Uniform(0, 1.2));
    Matrix6 JtJ = Matrix6::Zero();
    std::vector<Vector2d> on_plane;
    for (const PointPair& pair : Grid(X_CT)) {
      on_plane.push_back(pair.from);
      const Vector3d p_T(pair.from.x(), pair.from.y(), 0);
      Eigen::Matrix<double, 2, 6> J;
      for (int k = 0; k < 6; ++k) {
        const Vector6 d = 1e-5 * Vector6::Unit(k);
        const Pose plus{ExpRotation(d.tail<3>()) * X_CT.R, X_CT.p + d.head<3>()};
        const Pose minus{ExpRotation(-d.tail<3>()) * X_CT.R, X_CT.p - d.head<3>()};
        J.col(k) = (*kCamera.Project(plus * p_T) - *kCamera.Project(minus * p_T)) / 2e-5;
      }
      JtJ += J.transpose() * J;
    }
    const auto information = PoseInformation(on_plane, kCamera, X_CT);
    ASSERT_TRUE(information);
    EXPECT_LT((*information - JtJ).norm(), 1e-6 * JtJ.norm()) << i;
  }
}

// The bound and what estimates come to, by many draws: the likeliest reaches it where noise is small, and no method
// is below it.
TEST(PoseInformation, BoundsTheCovarianceOfManyDraws) {
  Random random(45);
  const Pose X_CT{ExpRotation({0.5, -0.3, 0}) * ExpRotation({0, 0, 2.2}), {0.3, -0.2, 3}};
  const double sigma = 0.2;
  std::vector<Vector2d> on_plane;
  for (const PointPair& pair : Grid(X_CT)) on_plane.push_back(pair.from);
  const Matrix6 bound = sigma * sigma * PoseInformation(on_plane, kCamera, X_CT)->inverse();
  constexpr int kDraws = 600;
  Matrix6 likely = Matrix6::Zero(), ippe = Matrix6::Zero(), sqpnp = Matrix6::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const std::vector<PointPair> pairs = Grid(X_CT, &random, sigma);
    const auto add = [&](const Pose& pose, Matrix6& sum) {
      const Vector6 off = Between(X_CT, pose);
      sum += off * off.transpose() / kDraws;
    };
    add(MostLikelyPlanePose(pairs, kCamera, sigma)->X_CT, likely);
    add(IppePoses(pairs, kCamera, sigma)[0].X_CT, ippe);
    add(SqpnpPose(pairs, kCamera, sigma)->X_CT, sqpnp);
  }
  const double slack = 4 * std::sqrt(2.0 / kDraws);
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(likely(k, k) / bound(k, k), 1, slack) << k;
    EXPECT_GT(ippe(k, k), (1 - slack) * bound(k, k)) << k;
    EXPECT_GT(sqpnp(k, k), (1 - slack) * bound(k, k)) << k;
  }
}

TEST(PlanePnp, StatesTheCovarianceOfItsPose) {
  Random random(46);
  const std::vector<PointPair> pairs = Grid(random.PadPose(0.5), &random, 0.3);
  const auto likely = MostLikelyPlanePose(pairs, kCamera, 0.3);
  const auto ippe = IppePoses(pairs, kCamera, 0.3);
  const auto sqpnp = SqpnpPose(pairs, kCamera, 0.3);
  ASSERT_TRUE(likely && sqpnp && !ippe.empty());
  for (const PlanePose& pose : {ippe[0], *sqpnp}) {
    const Matrix6 product = pose.covariance * likely->covariance.inverse();
    EXPECT_NEAR(product.trace() / 6, 1, 0.2);
    const Vector6 off = Between(likely->X_CT, pose.X_CT);
    EXPECT_LT(off.dot(likely->covariance.inverse() * off), 9);
  }
}

TEST(PlanePnp, RefusesWhatFixesNoPose) {
  Random random(47);
  const std::vector<PointPair> pairs = Grid(random.PadPose(0.5));
  std::vector<PointPair> broken = pairs, line, three_on_a_line;
  broken[3].to.x() = std::numeric_limits<double>::quiet_NaN();
  for (const PointPair& pair : pairs)
    if (pair.from.x() == pairs[0].from.x()) line.push_back(pair);
  ASSERT_EQ(line.size(), 5u);
  std::vector<PointPair> same_pixel = pairs;
  for (PointPair& pair : same_pixel) pair.to = pairs[0].to;
  for (const auto& open : {std::vector<PointPair>(pairs.begin(), pairs.begin() + 3), broken, line,
                           std::vector<PointPair>(6, pairs[0])}) {
    EXPECT_TRUE(IppePoses(open, kCamera, 0.1).empty());
    EXPECT_FALSE(SqpnpPose(open, kCamera, 0.1));
    EXPECT_FALSE(MostLikelyPlanePose(open, kCamera, 0.1));
  }
  EXPECT_NO_THROW(IppePoses(same_pixel, kCamera, 0.1));
  EXPECT_FALSE(SqpnpPose(same_pixel, kCamera, 0.1));
}

}  // namespace
}  // namespace kestrel::vision
