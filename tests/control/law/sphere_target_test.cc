// SPDX-License-Identifier: Apache-2.0
#include "control/law/sphere_target.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/pose.h"
#include "tests/control/law/numeric_interaction.h"

namespace kestrel::control {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDiameter = 0.6;

Vector3d RandomTarget(std::mt19937& rng) {
  std::uniform_real_distribution<double> u(-1, 1);
  const double Z = 4 + 3 * u(rng);
  return {0.8 * Z * u(rng), 0.8 * Z * u(rng), Z};
}

TEST(SphereInteraction, IsTheDerivativeByItsDefinition) {
  std::mt19937 rng(5);
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = RandomTarget(rng);
    const Eigen::MatrixXd numeric =
        NumericInteraction([](const Vector3d& q) { return SphereImageOf(q, kDiameter).Vector(); }, p);
    const Eigen::MatrixXd L = SphereInteraction(SphereImageOf(p, kDiameter), p.z());
    EXPECT_LT((L - numeric).norm(), 1e-8 * L.norm());
    EXPECT_NEAR(SphereDepth(SphereImageOf(p, kDiameter), kDiameter), p.z(), 1e-12);
  }
}

TEST(SphereInteraction, ThePrintedInversesAreInverses) {
  std::mt19937 rng(6);
  for (int i = 0; i < 50; ++i) {
    const Vector3d p = RandomTarget(rng);
    const SphereImage image = SphereImageOf(p, kDiameter);
    EXPECT_LT((FollowInteraction(image, p.z()) * FollowInverse(image, p.z()) - Matrix3d::Identity()).norm(),
              1e-12);
    EXPECT_LT(
        (DecoupledInteraction(image, p.z()) * DecoupledInverse(image, p.z()) - Matrix3d::Identity()).norm(),
        1e-12);
  }
}

TEST(SphereInteraction, OnTheAxisTheDecoupledFormIsTheWhole) {
  const SphereImage image = SphereImageOf({0, 0, 3}, kDiameter);
  EXPECT_LT((FollowInteraction(image, 3) - DecoupledInteraction(image, 3)).norm(), 1e-15);
}

// The camera moves with (v_y, v_z, w_y); the sphere stands still.
Vector3d Seen(const Vector3d& p_CT, const Vector3d& velocity, double dt) {
  const Pose X_CD{ExpRotation({0, dt * velocity[2], 0}), {0, dt * velocity[0], dt * velocity[1]}};
  return X_CD.Inverse() * p_CT;
}

TEST(FollowVelocity, WholeItBringsTheImageHomeOnAStraightLineDecoupledItAlsoArrives) {
  const SphereImage wanted{{0, 0}, 0.2};
  const double lambda = 0.9, dt = 1e-3;
  const Vector3d lambdas = Vector3d::Constant(lambda);
  for (const auto coupling : {FollowCoupling::kCoupled, FollowCoupling::kDecoupled}) {
    Vector3d p(1.5, -0.8, 4);
    const Vector3d start = SphereImageOf(p, kDiameter).Vector() - wanted.Vector();
    double off_line = 0;
    for (int i = 1; i <= 8000; ++i) {
      const SphereImage now = SphereImageOf(p, kDiameter);
      const FollowStep step = FollowVelocity(now, wanted, p.z(), coupling, lambdas);
      ASSERT_EQ(step.state, ServoState::kRegular);
      p = Seen(p, step.velocity, dt);
      const Vector3d error = SphereImageOf(p, kDiameter).Vector() - wanted.Vector();
      off_line = std::max(off_line, (error - std::exp(-lambda * i * dt) * start).norm());
    }
    EXPECT_LT((SphereImageOf(p, kDiameter).Vector() - wanted.Vector()).norm(), 1e-3);
    if (coupling == FollowCoupling::kCoupled) {
      EXPECT_LT(off_line, 1e-3);  // the integrator's, as in the tests of pbvs
    } else {
      EXPECT_GT(off_line, 1e-2);  // the price of the loops' ignorance of each other
    }
  }
}

// The sphere flies off at a constant velocity: with its drift the image comes to rest at the one wanted, and
// without it behind.
TEST(FollowVelocity, WithItsDriftItFollowsWithoutALag) {
  const SphereImage wanted{{0.1, -0.05}, 0.15};
  const double dt = 1e-3;
  for (const bool knows : {true, false}) {
    Vector3d p(0.5, 0.3, 3);
    Eigen::Quaterniond R_NC = Eigen::Quaterniond::Identity();
    for (int i = 0; i < 8000; ++i) {
      const Vector3d v_C = R_NC.conjugate() * Vector3d(0.4, -0.2, 0.8);
      const SphereImage now = SphereImageOf(p, kDiameter);
      const Vector3d drift = knows ? SphereDrift(now, p.z(), v_C) : Vector3d::Zero();
      const FollowStep step =
          FollowVelocity(now, wanted, p.z(), FollowCoupling::kCoupled, Vector3d::Constant(1.5), drift);
      p = Seen(p + dt * v_C, step.velocity, dt);
      R_NC = R_NC * ExpRotation({0, dt * step.velocity[2], 0});
    }
    const double off = (SphereImageOf(p, kDiameter).Vector() - wanted.Vector()).norm();
    if (knows)
      EXPECT_LT(off, 2e-3);
    else
      EXPECT_GT(off, 1e-2);
  }
}

TEST(FollowVelocity, WithoutADepthOrAnImageItStandsStillAndSaysWhy) {
  const SphereImage image{{0.1, 0.2}, 0.1};
  EXPECT_EQ(FollowVelocity(image, image, -1, FollowCoupling::kCoupled, Vector3d::Ones()).state,
            ServoState::kDepthNotPositive);
  EXPECT_EQ(FollowVelocity({{0.1, 0}, 0}, image, 1, FollowCoupling::kCoupled, Vector3d::Ones()).state,
            ServoState::kDepthNotPositive);
  const FollowStep step =
      FollowVelocity({{std::nan(""), 0}, 0.1}, image, 1, FollowCoupling::kDecoupled, Vector3d::Ones());
  EXPECT_EQ(step.state, ServoState::kNotFinite);
  EXPECT_EQ(step.velocity, Vector3d::Zero());
}

}  // namespace
}  // namespace kestrel::control
