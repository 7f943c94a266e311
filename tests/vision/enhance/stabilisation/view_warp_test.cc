// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/view_warp.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "geometry/pose.h"
#include "tests/vision/enhance/motion/random_scene.h"

namespace kestrel::vision {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kWidth = 160, kHeight = 120;
const Pinhole kCamera{.width_px = kWidth, .height_px = kHeight, .fx = 150, .fy = 150, .cx = 79.5, .cy = 59.5};

// The camera turns by 0.24 rad while its rows are exposed.
ImageView TurningView() {
  ImageView view;
  view.size = {kWidth, kHeight}, view.rows = kHeight;
  view.turned = true, view.virtual_camera = kCamera;
  for (int i = 0; i < 16; ++i)
    view.R_NC_rows.push_back(ExpRotation((i / 15.0 - 0.5) * Vector3d(0.05, 0.2, 0.12)));
  return view;
}

// What is far away, by a camera whose row v has attitude R_NC(v).
template <typename Attitude>
cv::Mat Draw(const Attitude& R_NC) {
  static const cv::Mat scene = RandomScene({800, 800}, 6, 5);
  cv::Mat u(kHeight, kWidth, CV_32F), v(kHeight, kWidth, CV_32F), image;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Vector3d ray_N = R_NC(y) * *kCamera.Ray(Vector2d(x, y));
      u.at<float>(y, x) = static_cast<float>(400 + 200 * ray_N.x() / ray_N.z());
      v.at<float>(y, x) = static_cast<float>(400 + 200 * ray_N.y() / ray_N.z());
    }
  }
  cv::remap(scene, image, u, v, cv::INTER_LINEAR);
  return image;
}

TEST(ViewWarp, RowsThatWereExposedWhileTheCameraTurnedAreUndone) {
  const ImageView view = TurningView();
  const cv::Mat rolling = Draw([&](int row) { return AttitudeOfRow(view.R_NC_rows, kHeight, row); }),
                global = Draw([](int) { return Quaterniond::Identity(); });
  const CameraModel camera = kCamera;
  cv::Mat shown;
  const cv::Mat undone = DrawView(view, &camera, rolling, &shown);
  ASSERT_GT(cv::countNonZero(shown), kWidth * kHeight * 3 / 4);
  const double before = cv::norm(rolling, global, cv::NORM_L1, shown),
               after = cv::norm(undone, global, cv::NORM_L1, shown);
  EXPECT_GT(before / cv::countNonZero(shown), 15);
  EXPECT_LT(after, 0.1 * before);
}

TEST(ViewWarp, SourceAndPlaceShownAreInverse) {
  ImageView view = TurningView();
  view.R_NV = ExpRotation(Vector3d(0.02, -0.05, 0.1));
  view.H << 1.2, 0.01, -8, -0.02, 1.2, -5, 1e-5, 0, 1;
  const CameraModel camera = kCamera;
  int places = 0;
  for (int y = 10; y < kHeight; y += 20) {
    for (int x = 10; x < kWidth; x += 20, ++places) {
      const auto source = SourceOf(view, &camera, Vector2d(x, y));
      ASSERT_TRUE(source);
      const auto back = ShownAt(view, &camera, *source);
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Vector2d(x, y)).norm(), 1e-2);
    }
  }
  EXPECT_EQ(places, 48);
}

TEST(ViewWarp, AttitudesGoOnEvenlyBetweenAndBeyondTheRowsGiven) {
  const Vector3d turn(0.1, -0.2, 0.3);
  const std::vector<Quaterniond> ends = {Quaterniond::Identity(), ExpRotation(turn)};
  for (const double row : {-10.0, 0.0, 25.0, 100.0, 120.0})
    EXPECT_LT(AttitudeOfRow(ends, 101, row).angularDistance(ExpRotation(row / 100 * turn)), 1e-12) << row;
  EXPECT_LT(AttitudeOfRow({}, 101, 3).angularDistance(Quaterniond::Identity()), 1e-12);
}

}  // namespace
}  // namespace kestrel::vision
