// SPDX-License-Identifier: Apache-2.0
#include "mission/helipad_pilot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "sim/simulator.h"
#include "tests/vision/landmark/pad_photographer.h"

namespace kestrel::mission {
namespace {

vision::KannalaBrandt Fisheye() {
  vision::KannalaBrandt c;
  c.width_px = 640, c.height_px = 480;
  c.fx = c.fy = 241, c.cx = 322.3, c.cy = 236.8;
  c.k1 = -0.01, c.k2 = 0.002;
  c.max_angle_rad = Radians(95);
  return c;
}

// The same place and time through the fisheye: each pixel the mean of samples of a pinhole's finer image,
// grey where that does not reach.
cv::Mat ThroughFisheye(const cv::Mat& pinhole_image) {
  constexpr int kFine = 4;
  const vision::KannalaBrandt camera = Fisheye();
  cv::Mat image(camera.height_px, camera.width_px, CV_8UC1, cv::Scalar(105));
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      double sum = 0;
      int samples = 0;
      for (int k = 0; k < kFine * kFine; ++k) {
        const Eigen::Vector2d at(u + (k % kFine + 0.5) / kFine - 0.5, v + (k / kFine + 0.5) / kFine - 0.5);
        const auto ray = camera.Ray(at);
        const auto uv = ray ? vision::kPadCamera.Project(*ray) : std::nullopt;
        if (!uv || !(uv->x() > 0 && uv->y() > 0 && uv->x() < 638 && uv->y() < 478)) continue;
        cv::Mat one;
        cv::getRectSubPix(pinhole_image, {1, 1}, cv::Point2f(uv->cast<float>().x(), uv->cast<float>().y()),
                          one);
        sum += one.at<uchar>(0, 0);
        ++samples;
      }
      if (samples == kFine * kFine) image.at<uchar>(v, u) = cv::saturate_cast<uchar>(sum / samples);
    }
  }
  return image;
}

TEST(HelipadPilotTest, SeesThePadThroughAFisheyeAndDrawsItWhereItIs) {
  const Pose X_BC = vision::MountPose({});
  const Pose X_CT = vision::PadBelow({0.1, -0.3, 4}, 20);
  const Pose X_TB = (X_BC * X_CT).Inverse();
  control::VehicleState state;
  state.t_s = 1;
  state.R_NB = X_TB.R;  // the pad lies to the north
  HelipadPilot pilot(
      vision::MakePadReference(vision::PadPicture(), vision::kPadLength_m, vision::kPadWidth_m), Fisheye(),
      X_BC, {});
  const cv::Mat image = ThroughFisheye(vision::PadPhotographer(vision::PadPicture()).At(X_CT, 1));
  const Decision decision = pilot.Observe({image, 1, 0}, state);
  ASSERT_TRUE(decision.fix);
  EXPECT_TRUE(decision.fix->registered);
  // So small a pad shows its tilt to 0.4 degrees, which are 3 cm over 4 m; by three of that.
  EXPECT_LT((decision.fix->p_TB - X_TB.p).norm(), 0.09);
  EXPECT_NEAR(Degrees(decision.fix->yaw_TB), Degrees(YawOf(X_TB.R)), 0.3);

  cv::Mat drawn(image.size(), CV_8UC3, cv::Scalar(0, 0, 0));
  pilot.Draw(drawn);
  const double x = vision::kPadLength_m / 2, y = vision::kPadWidth_m / 2;
  for (const Eigen::Vector3d& p_T : {Eigen::Vector3d(x, y, 0), Eigen::Vector3d(x, 0, 0),
                                     Eigen::Vector3d(-x, 0.2, 0), Eigen::Vector3d(-0.3, -y, 0)}) {
    const auto uv = Fisheye().Project(X_CT * p_T);
    ASSERT_TRUE(uv);
    const cv::Vec3b colour =
        drawn.at<cv::Vec3b>(static_cast<int>(std::lround(uv->y())), static_cast<int>(std::lround(uv->x())));
    EXPECT_GT(colour[0] + colour[1] + colour[2], 100) << uv->transpose();
  }
  // And nothing away from the pad.
  cv::Mat bright;
  cv::inRange(drawn, cv::Scalar(0, 0, 0), cv::Scalar(30, 30, 30), bright);
  EXPECT_LT(image.total() - static_cast<std::size_t>(cv::countNonZero(bright)), 110u * 110u);
}

TEST(TrackersCameraTest, IsAPinholeItselfOrTheVirtualOneOfAWideLens) {
  const auto same = TrackersCamera(vision::kPadCamera);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->width_px, 640);
  EXPECT_EQ(same->fx, vision::kPadCamera.fx);
  const auto within = TrackersCamera(Fisheye());
  ASSERT_TRUE(within);
  EXPECT_NEAR(within->fx, 241, 0.1);
  EXPECT_NEAR(2 * Degrees(std::atan2(within->width_px, 2 * within->fx)), 100, 1);
  vision::KannalaBrandt aside = Fisheye();
  aside.cx = -20;
  EXPECT_FALSE(TrackersCamera(aside));
}

}  // namespace
}  // namespace kestrel::mission
