// SPDX-License-Identifier: Apache-2.0
#include "sim/world/frames.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "base/diagnostics.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// A body with sites ahead, to the right and below: the places are given as forward, left, up.
constexpr char kBody[] =
    R"(<mujoco><option timestep="1e-6" gravity="0 0 0"/><worldbody><body name="b"><freejoint/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    <site name="ahead" pos="1 0 0"/><site name="right" pos="0 -1 0"/><site name="below" pos="0 0 -1"/>
    <site name="corner" pos="0.3 -0.2 -0.7"/></body></worldbody></mujoco>)";

class Frames : public ::testing::Test {
 protected:
  void SetUp() override {
    mju_user_warning = [](const char* message) { ADD_FAILURE() << message; };
    mjVFS vfs;
    mj_defaultVFS(&vfs);
    mj_makeEmptyFileVFS(&vfs, "b.xml", sizeof kBody);
    std::memcpy(vfs.filedata[0], kBody, sizeof kBody);
    std::array<char, 500> error{};
    model_.reset(mj_loadXML("b.xml", &vfs, error.data(), error.size()));
    mj_deleteVFS(&vfs);
    ASSERT_TRUE(model_) << error.data();
    data_.reset(mj_makeData(model_.get()));
  }
  void TearDown() override { mju_user_warning = nullptr; }

  Vector3d SiteInN(const char* name) const {
    return VectorFromMujoco(data_->site_xpos + 3 * mj_name2id(model_.get(), mjOBJ_SITE, name));
  }
  void Place(const Pose& X_NB) {
    PoseToMujoco(X_NB, data_->qpos);
    mj_forward(model_.get(), data_.get());
  }
  static Pose RandomPose(std::mt19937& rng) {
    std::normal_distribution<double> n;
    return {Quaterniond(n(rng), n(rng), n(rng), n(rng)).normalized(), {n(rng), n(rng), n(rng)}};
  }

  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model_{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data_{nullptr, mj_deleteData};
};

TEST_F(Frames, NorthIsMujocosXEastItsMinusYAndDownItsMinusZ) {
  double v_M[3];
  VectorToMujoco({1, 2, 3}, v_M);
  EXPECT_EQ(Vector3d(v_M), Vector3d(1, -2, -3));
  EXPECT_EQ(VectorFromMujoco(v_M), Vector3d(1, 2, 3));
}

TEST_F(Frames, PointsOfAPlacedBodyAreWhereMujocoPutsThem) {
  std::mt19937 rng{7};
  for (int i = 0; i < 50; ++i) {
    const Pose X_NB = RandomPose(rng);
    Place(X_NB);
    EXPECT_LT((SiteInN("ahead") - X_NB * Vector3d(1, 0, 0)).norm(), 1e-12);
    EXPECT_LT((SiteInN("right") - X_NB * Vector3d(0, 1, 0)).norm(), 1e-12);
    EXPECT_LT((SiteInN("below") - X_NB * Vector3d(0, 0, 1)).norm(), 1e-12);
    EXPECT_LT((SiteInN("corner") - X_NB * Vector3d(0.3, 0.2, 0.7)).norm(), 1e-12);
  }
}

TEST_F(Frames, PoseComesBack) {
  std::mt19937 rng{7};
  for (int i = 0; i < 50; ++i) {
    const Pose X_NB = RandomPose(rng);
    double qpos[7];
    PoseToMujoco(X_NB, qpos);
    const Pose back = PoseFromMujoco(qpos);
    EXPECT_EQ(back.p, X_NB.p);
    EXPECT_EQ(back.R.coeffs(), X_NB.R.coeffs());
  }
}

TEST_F(Frames, YawToTheEastPitchNoseUpRollRightWingDownInMujocosWorld) {
  const auto height_of = [&](const char* name) {
    return data_->site_xpos[3 * mj_name2id(model_.get(), mjOBJ_SITE, name) + 2];
  };
  const auto turn = [&](const TaitBryan& a) {
    Place({Quaterniond(RotationFromTaitBryan(a)), Vector3d::Zero()});
  };
  turn({.yaw = 0.3});
  EXPECT_NEAR(data_->site_xpos[1], -std::sin(0.3), 1e-12);  // of "ahead", the first site; y is west
  turn({.pitch = 0.3});
  EXPECT_NEAR(height_of("ahead"), std::sin(0.3), 1e-12);
  turn({.roll = 0.3});
  EXPECT_NEAR(height_of("right"), -std::sin(0.3), 1e-12);
}

TEST_F(Frames, ClimbingAircraftRisesInMujoco) {
  Place({Quaterniond::Identity(), {4, 5, -6}});
  EXPECT_EQ(Vector3d(data_->xpos + 3), Vector3d(4, -5, 6));
}

TEST_F(Frames, VelocitiesOfTheFreeJointAreLinearInTheWorldAndAngularInTheBody) {
  std::mt19937 rng{7};
  for (int i = 0; i < 10; ++i) {
    const Pose X_NB = RandomPose(rng);
    const Vector3d v_N(0.4, -0.8, 1.2), w_B(0.5, -1.1, 0.7);
    PoseToMujoco(X_NB, data_->qpos);
    VectorToMujoco(v_N, data_->qvel);
    VectorToMujoco(w_B, data_->qvel + 3);
    mj_step(model_.get(), data_.get());
    const double dt = model_->opt.timestep;
    const Pose after = PoseFromMujoco(data_->qpos);
    EXPECT_LT(((after.p - X_NB.p) / dt - v_N).norm(), 1e-6);
    EXPECT_LT((LogRotation(X_NB.R.conjugate() * after.R) / dt - w_B).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace kestrel::sim
