// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/estimation/plane_pnp.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/vision/landmark/drawn_poses.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

TEST(PlanePnp, ExactPixelsGiveThePoseBack) {
  DrawnPoses random(41);
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
  DrawnPoses random(42);
  int both = 0, ambiguous = 0;
  for (int i = 0; i < 30; ++i) {
    Pose X_CT = random.PadPose(0.6);
    X_CT.p *= 3 / X_CT.p.norm();
    const auto near = IppePoses(Noisy(Grid(X_CT), 0.2, random), kCamera, 0.2);
    X_CT.p *= 10;
    const auto far = IppePoses(Noisy(Grid(X_CT), 0.2, random), kCamera, 0.2);
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
  DrawnPoses random(43);
  int cases = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose X_CT = random.PadPose(random.Uniform(0.1, 1.2));
    const std::vector<PointPair> pairs = Noisy(Grid(X_CT), 0.3, random);
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
  DrawnPoses random(44);
  for (int i = 0; i < 20; ++i) {
    const Pose X_CT = random.PadPose(random.Uniform(0, 1.2));
    const std::vector<PointPair> pairs = Grid(X_CT);
    std::vector<Vector2d> on_plane;
    for (const PointPair& pair : pairs) on_plane.push_back(pair.from);
    const Matrix6 JtJ = NumericInformation(pairs, X_CT);
    const auto information = PoseInformation(on_plane, kCamera, X_CT);
    ASSERT_TRUE(information);
    EXPECT_LT((*information - JtJ).norm(), 1e-6 * JtJ.norm()) << i;
  }
}

// The bound and what estimates come to, by many draws: the likeliest reaches it where noise is small, and no method
// is below it.
TEST(PoseInformation, BoundsTheCovarianceOfManyDraws) {
  DrawnPoses random(45);
  const Pose X_CT{ExpRotation({0.5, -0.3, 0}) * ExpRotation({0, 0, 2.2}), {0.3, -0.2, 3}};
  const double sigma = 0.2;
  std::vector<Vector2d> on_plane;
  for (const PointPair& pair : Grid(X_CT)) on_plane.push_back(pair.from);
  const Matrix6 bound = sigma * sigma * PoseInformation(on_plane, kCamera, X_CT)->inverse();
  constexpr int kDraws = 600;
  Matrix6 likely = Matrix6::Zero(), ippe = Matrix6::Zero(), sqpnp = Matrix6::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const std::vector<PointPair> pairs = Noisy(Grid(X_CT), sigma, random);
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
  DrawnPoses random(46);
  const std::vector<PointPair> pairs = Noisy(Grid(random.PadPose(0.5)), 0.3, random);
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
  DrawnPoses random(47);
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
