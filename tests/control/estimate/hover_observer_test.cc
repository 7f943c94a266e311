// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/hover_observer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kestrel::control {
namespace {

using Eigen::Vector3d;

// A body that is pushed to and fro by what is known and steadily by what is not, seen late.
struct Body {
  Vector3d p{0.5, -0.3, 0.2}, v{0, 0.1, 0};
  Vector3d Pushed(double t) const {
    return {0.5 * std::sin(3 * t), 0.4 * std::cos(2 * t), 0.2 * std::sin(t)};
  }
  void Step(double t, double dt, const Vector3d& d) {
    const Vector3d a = Pushed(t) + d;
    p += dt * v + dt * dt / 2 * a;
    v += dt * a;
  }
};

TEST(HoverObserver, FindsVelocityAndDisturbanceByTheOffsetAlone) {
  const Vector3d d(0.3, -0.2, 0.5);
  Body body;
  HoverObserver observer({});
  constexpr double kDt = 0.01;
  for (int k = 0; k < 800; ++k) {
    observer.AddAcceleration(k * kDt, body.Pushed(k * kDt));
    observer.Correct(k * kDt, body.p);
    body.Step(k * kDt, kDt, d);
  }
  const auto estimate = observer.At(800 * kDt);
  ASSERT_TRUE(estimate);
  EXPECT_LT((estimate->p_N - body.p).norm(), 1e-3);
  EXPECT_LT((estimate->v_N - body.v).norm(), 5e-3);
  EXPECT_LT((estimate->d_N - d).norm(), 0.02);
  EXPECT_NEAR(estimate->age_s, kDt, 1e-9);
}

TEST(HoverObserver, WhatIsSeenLateIsCarriedOnByWhatWasDoneSince) {
  const Vector3d d(0.1, 0, 0);
  for (const int late : {1, 5, 20}) {
    Body body;
    HoverObserver observer({});
    constexpr double kDt = 0.01;
    std::vector<Vector3d> seen;
    for (int k = 0; k < 800; ++k) {
      seen.push_back(body.p);
      observer.AddAcceleration(k * kDt, body.Pushed(k * kDt));
      if (k >= late) observer.Correct((k - late) * kDt, seen[static_cast<std::size_t>(k - late)]);
      body.Step(k * kDt, kDt, d);
    }
    const auto estimate = observer.At(800 * kDt);
    EXPECT_LT((estimate->p_N - body.p).norm(), 5e-3) << late;
    EXPECT_LT((estimate->v_N - body.v).norm(), 0.02) << late;
  }
}

TEST(HoverObserver, AGapBeginsAnewAndAnOldExposureIsPassedOver) {
  HoverObserver observer({});
  EXPECT_FALSE(observer.At(0));
  observer.Correct(1, {1, 0, 0});
  observer.Correct(0.9, {5, 0, 0});
  EXPECT_EQ(observer.At(1)->p_N, Vector3d(1, 0, 0));
  observer.Correct(3, {2, 0, 0});
  EXPECT_EQ(observer.At(3)->p_N, Vector3d(2, 0, 0));
  EXPECT_EQ(observer.At(3)->v_N, Vector3d::Zero());
  observer.Forget();
  EXPECT_FALSE(observer.At(3));
}

}  // namespace
}  // namespace kestrel::control
