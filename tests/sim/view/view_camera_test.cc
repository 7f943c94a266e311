// SPDX-License-Identifier: Apache-2.0
#include "sim/view/view_camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"
#include "tests/sim/pelican_over_a_plane.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

Truth At(double t_s, const Eigen::Vector3d& p_N, double yaw = 0) {
  Truth truth;
  truth.t_s = t_s;
  truth.X_NB = {HeadingRotation(yaw), p_N};
  return truth;
}

// Where a place is in the picture, as shares of its width and of its height from its middle.
Eigen::Vector2d InPicture(const ViewAim& aim, const ViewParameters& view, const Eigen::Vector3d& p_N) {
  const Eigen::Vector3d p_C = aim.X_NC.Inverse() * p_N;
  EXPECT_GT(p_C.z(), 0);
  const double half = std::tan(aim.fov_rad / 2) * p_C.z();
  return {p_C.x() / (2 * half), p_C.y() / (2 * half) * view.width_px / view.height_px};
}

double SizeInPicture(const ViewAim& aim, const Eigen::Vector3d& p_N, double radius_m) {
  return radius_m / ((aim.X_NC.Inverse() * p_N).z() * std::tan(aim.fov_rad / 2));
}

TEST(ViewCamera, EachKindHoldsAnAircraftInItsPictureThatFliesAboutAndTurns) {
  const ModelPtr model = PelicanOverAPlane();
  const double radius_m = AircraftRadius_m(model.get());
  EXPECT_NEAR(radius_m, 0.21 + 0.128, 0.02);  // to the tip of a rotor, by its file
  for (const std::string& kind : KindsOfView()) {
    ViewParameters view;
    view.kind = kind;
    if (kind == "free") view.position = ViewPlace{-6, 4, 3};
    ViewCamera camera(model.get(), view);
    for (int i = 0; i < 600; ++i) {
      const double t = i / 30.0;
      const Eigen::Vector3d p(4 * std::sin(0.3 * t), 4 * std::cos(0.3 * t), -4 - 2 * std::sin(0.5 * t));
      const ViewAim aim = camera.At(At(t, p, 0.9 * t));
      const Eigen::Vector2d at = InPicture(aim, view, p);
      EXPECT_LT(at.cwiseAbs().maxCoeff(), 0.3) << kind << ' ' << t;
      const double size = SizeInPicture(aim, p, radius_m);
      EXPECT_GT(size, 0.05) << kind << ' ' << t;
      EXPECT_LT(size, 0.5) << kind << ' ' << t;
      EXPECT_LT(aim.X_NC.p.z(), 0) << kind << " is below the ground";
      // Upright: the picture's right is level.
      EXPECT_NEAR((aim.X_NC.R * Eigen::Vector3d::UnitX()).z(), 0, 1e-9) << kind;
    }
  }
}

TEST(ViewCamera, ChaseIsBehindAndAboveSoonAfterATurn) {
  const ModelPtr model = PelicanOverAPlane();
  ViewCamera camera(model.get(), {});
  const Eigen::Vector3d p(0, 0, -5);
  camera.At(At(0, p));
  const auto bearing = [&](const ViewAim& aim) { return std::atan2(-aim.X_NC.p.y(), -aim.X_NC.p.x()); };
  const double soon = bearing(camera.At(At(0.1, p, Radians(90))));
  EXPECT_GT(soon, 0);
  EXPECT_LT(soon, Radians(20)) << "it follows softly";
  ViewAim late;
  for (int i = 1; i < 300; ++i) late = camera.At(At(0.1 + i / 30.0, p, Radians(90)));
  EXPECT_NEAR(bearing(late), Radians(90), Radians(1));
  EXPECT_LT(late.X_NC.p.z(), p.z()) << "above";
}

TEST(ViewCamera, TowerStaysAtEyeHeightAndZoomsInOnWhatFliesAway) {
  const ModelPtr model = PelicanOverAPlane();
  ViewParameters view;
  view.kind = "tower";
  ViewCamera camera(model.get(), view);
  const ViewAim near = camera.At(At(0, {0, 0, -3})), far = camera.At(At(1, {60, 0, -3}));
  EXPECT_EQ(near.X_NC.p, far.X_NC.p);
  EXPECT_DOUBLE_EQ(near.X_NC.p.z(), -1.7);
  EXPECT_LT(far.fov_rad, near.fov_rad / 2);
}

TEST(ViewCamera, TopLooksStraightDownWithNorthUp) {
  const ModelPtr model = PelicanOverAPlane();
  ViewParameters view;
  view.kind = "top";
  const ViewAim aim = ViewCamera(model.get(), view).At(At(0, {3, 4, -5}, 1));
  EXPECT_TRUE((aim.X_NC.R * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE((aim.X_NC.R * Eigen::Vector3d(0, -1, 0)).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(aim.X_NC.p.head<2>().isApprox(Eigen::Vector2d(3, 4), 1e-12));
}

// Behind a wall nothing is seen: the camera comes before it.
TEST(ViewCamera, NoWallComesBetween) {
  const ModelPtr model = CompileScene(R"(<mujoco><worldbody>
      <geom type="plane" size="100 100 1"/>
      <geom type="box" pos="-1 0 5" size="0.05 20 10"/>
      <body name="vehicle"><freejoint/><geom type="sphere" size="0.3"/></body></worldbody></mujoco>)");
  const Eigen::Vector3d p(0, 0, -3);
  const ViewAim aim = ViewCamera(model.get(), {}).At(At(0, p));
  EXPECT_GT(aim.X_NC.p.x(), -0.95) << "the wall's face is there";
  EXPECT_LT(aim.X_NC.p.x(), -0.5);
}

}  // namespace
}  // namespace kestrel::sim
