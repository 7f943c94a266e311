// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/snapshots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "geometry/tait_bryan.h"
#include "sim/world/frames.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

// An aircraft, a swinging beam and a sheet, moving evenly: at t the aircraft is at (t, 2 t, -3) m of N,
// turned by 60 t deg, and the beam by 90 t deg.
class InstantsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* xml = R"(<mujoco><worldbody>
        <body name="vehicle"><freejoint/><geom size="0.1"/></body>
        <body name="beam" pos="5 0 0"><joint type="hinge" axis="0 0 1"/>
          <geom name="tip" size="0.1" pos="1 0 0"/></body>
        <body name="sheet" mocap="true"><geom size="0.1" contype="0" conaffinity="0"/></body>
      </worldbody></mujoco>)";
    mjVFS files;
    mj_defaultVFS(&files);
    mj_makeEmptyFileVFS(&files, "m.xml", static_cast<int>(std::strlen(xml)));
    std::memcpy(files.filedata[0], xml, std::strlen(xml));
    char error[500] = "";
    model_.reset(mj_loadXML("m.xml", &files, error, sizeof error));
    mj_deleteVFS(&files);
    ASSERT_TRUE(model_) << error;
    data_ = MakeData(model_.get());
  }
  static Pose X_NB(double t) { return {HeadingRotation(Radians(60 * t)), {t, 2 * t, -3}}; }
  Snapshot At(double t) {
    PoseToMujoco(X_NB(t), data_->qpos);
    data_->qpos[7] = Radians(90 * t);
    data_->mocap_pos[0] = 7 * t;
    data_->mocap_quat[0] = std::cos(t), data_->mocap_quat[3] = std::sin(t);
    return SnapshotOf(model_.get(), data_.get(), t);
  }
  std::vector<Snapshot> Snapshots(int first, int last) {
    std::vector<Snapshot> snapshots;
    for (int i = first; i <= last; ++i) snapshots.push_back(At(0.002 * i));
    return snapshots;
  }
  Vector3d TipOfBeam(const SceneState& state) const {
    return VectorFromMujoco(state.data->geom_xpos + 3 * mj_name2id(model_.get(), mjOBJ_GEOM, "tip"));
  }
  static void ExpectNear(const Pose& a, const Pose& b, double tolerance) {
    EXPECT_LT((a.p - b.p).norm(), tolerance);
    EXPECT_LT(a.R.angularDistance(b.R), tolerance + 1e-7);
  }

  ModelPtr model_;
  DataPtr data_;
  const Pose X_BC_{HeadingRotation(0.5), {0.1, 0.2, 0.3}};
};

TEST_F(InstantsTest, AnInstantIsItsMoment) {
  SnapshotInterpolator interpolator(model_.get(), X_BC_, Vibration({}, 1));
  const auto of = interpolator.Of(Snapshots(3, 9), 0.012, 0.012);
  ASSERT_EQ(of.size(), 1u);
  EXPECT_EQ(of[0].t_s, 0.012);
  ExpectNear(of[0].X_NC, X_NB(0.012) * X_BC_, 1e-12);
  EXPECT_LT((TipOfBeam(of[0]) - Vector3d(5 + std::cos(Radians(1.08)), -std::sin(Radians(1.08)), 0)).norm(),
            1e-12);
  ASSERT_EQ(interpolator.Of({At(3.5)}, 3, 4).size(), 1u);
}

TEST_F(InstantsTest, TheyEncloseTheExposureAsFarAsThereAreMoments) {
  SnapshotInterpolator interpolator(model_.get(), X_BC_, Vibration({}, 1));
  const std::vector<Snapshot> snapshots = Snapshots(0, 10);
  const auto ends = [&](double from_s, double until_s) {
    const auto of = interpolator.Of(snapshots, from_s, until_s);
    for (std::size_t i = 0; i < of.size(); ++i) {
      EXPECT_NEAR(of[i].t_s, of[0].t_s + 0.002 * static_cast<double>(i), 1e-12);
      ExpectNear(of[i].X_NC, X_NB(of[i].t_s) * X_BC_, 1e-12);  // each has data of its own
      EXPECT_NEAR(std::atan2(-TipOfBeam(of[i]).y(), TipOfBeam(of[i]).x() - 5), Radians(90 * of[i].t_s),
                  1e-12);
    }
    return std::pair(std::lround(of.front().t_s / 0.002), std::lround(of.back().t_s / 0.002));
  };
  EXPECT_EQ(ends(0.0051, 0.0111), std::pair(2l, 6l));
  EXPECT_EQ(ends(0.004, 0.012), std::pair(2l, 6l));
  EXPECT_EQ(ends(0.0045, 0.0055), std::pair(2l, 3l));
  EXPECT_EQ(ends(-1, 0.003), std::pair(0l, 2l));
  EXPECT_EQ(ends(0.017, 5), std::pair(8l, 10l));
  EXPECT_EQ(ends(-2, -1), std::pair(0l, 0l));
  EXPECT_EQ(ends(3, 4), std::pair(10l, 10l));
}

TEST_F(InstantsTest, ACameraOnAPlatformIsWhereItStoodThen) {
  const Vibration vibration({{190, 200, 0, 0}},
                            3);  // shakes by nothing, but asks for interpolator in between
  SnapshotInterpolator interpolator(model_.get(), X_BC_, vibration);
  const auto platform = [](double t) { return Pose{HeadingRotation(Radians(40 * t)), {t, -t, 0.2}}; };
  std::vector<Snapshot> snapshots = Snapshots(0, 10);
  for (Snapshot& m : snapshots) m.X_BC = platform(m.t_s);
  for (const SceneState& i : interpolator.Of(snapshots, 0.004, 0.016))
    ExpectNear(i.X_NC, X_NB(i.t_s) * platform(i.t_s), 1e-9);
}

TEST_F(InstantsTest, WhereTheMountShakesThereAreInstantsBetweenTheSteps) {
  const Vibration vibration({{190, 200, 1, 2}}, 3);
  SnapshotInterpolator interpolator(model_.get(), X_BC_, vibration);
  const auto of = interpolator.Of(Snapshots(0, 10), 0.004, 0.016);
  EXPECT_EQ(of.size(), 25u);  // 4 in a step: 8 in a period of 5 ms, nearly
  bool shaken = false;
  for (const SceneState& i : of) {
    EXPECT_LT(i.t_s, 0.016 + 1e-12);
    // between two steps the world moves evenly, and the camera as it shakes at that very time
    ExpectNear(i.X_NC, X_NB(i.t_s) * X_BC_ * vibration.At(i.t_s), 1e-9);
    EXPECT_NEAR(std::atan2(-TipOfBeam(i).y(), TipOfBeam(i).x() - 5), Radians(90 * i.t_s), 1e-12);
    EXPECT_NEAR(i.data->mocap_pos[0], 7 * i.t_s, 1e-12);
    EXPECT_NEAR(i.data->mocap_quat[3], std::sin(i.t_s), 1e-12);
    shaken = shaken || vibration.At(i.t_s).p.norm() > 1e-3;
  }
  EXPECT_TRUE(shaken);
}

}  // namespace
}  // namespace kestrel::sim
