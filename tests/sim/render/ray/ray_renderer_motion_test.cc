// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "sim/render/ray/ray_renderer.h"
#include "tests/sim/image_difference.h"
#include "tests/sim/render/reference_renderer.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

vision::CameraModel Fisheye() {
  vision::KannalaBrandt fisheye{.width_px = 85, .height_px = 70, .fx = 24, .fy = 24, .cx = 42, .cy = 34.5};
  fisheye.k1 = 0.01, fisheye.max_angle_rad = 1.7;
  return fisheye;
}
const vision::CameraModel kPinhole = vision::Pinhole{90, 66, 75, 75, 44.5, 32.5};

// A field, a shed and a roof that stand, a box that flies and turns, a mesh that rises, a lamp that goes
// along, seen by a camera that flies and turns itself.
class Flight : public ::testing::Test {
 protected:
  Flight()
      : model_(CompileScene(R"(<mujoco>
  <visual><headlight ambient="0.5 0.5 0.5" diffuse="0.2 0.2 0.2" specular="0 0 0"/></visual>
  <asset>
    <texture name="sky" type="skybox" file="faces.png" gridsize="6 1" gridlayout="RLUDFB"/>
    <texture name="picture" type="2d" file="picture.png"/><material name="picture" texture="picture" specular="0"/>
    <mesh name="wedge" vertex="-1 -0.6 -0.5  1 -0.6 -0.5  1 0.6 -0.5  -1 0.6 -0.5  0 0 0.9"
      face="0 2 1  0 3 2  0 1 4  1 2 4  2 3 4  3 0 4"/>
  </asset>
  <worldbody>
    <geom type="plane" size="30 30 1" pos="0 0 -2" material="picture"/>
    <geom type="box" pos="8 3 -1" size="1 1 1" rgba="0.3 0.6 0.8 1"/>
    <geom type="capsule" pos="5 -2.5 0" size="0.4 1" rgba="0.9 0.9 0.2 1"/>
    <body><freejoint/><geom type="box" size="0.5 0.6 0.4" material="picture"/>
      <light pos="0 0 2" dir="0 0 -1" cutoff="60" diffuse="0.3 0.3 0.3"/></body>
    <body mocap="true"><geom type="mesh" mesh="wedge" rgba="0.8 0.3 0.3 1"/></body>
  </worldbody>
</mujoco>)")) {}

  // Everything moves evenly: what is interpolated between two instants is what happens.
  DataPtr StateAt(double t_s) const {
    DataPtr data = MakeData(model_.get());
    const double turn = 0.3 * t_s;  // rad, half of the angle
    const double qpos[7] = {4, 0.3 - 2 * t_s,        0.3 + t_s,           std::cos(turn),
                            0, 0.6 * std::sin(turn), 0.8 * std::sin(turn)};
    std::copy(qpos, qpos + 7, data->qpos);
    data->mocap_pos[0] = 6, data->mocap_pos[1] = 1.5, data->mocap_pos[2] = t_s;
    mj_forward(model_.get(), data.get());
    return data;
  }
  static Pose CameraAt(double t_s) { return LookingFrom({1.5 * t_s, 0.4 - t_s, -0.3}, 0, 0, 0.5 * t_s); }

  cv::Mat At(RayRenderer& renderer, double t_s) const {
    return renderer.Render(StateAt(t_s).get(), CameraAt(t_s));
  }

  ModelPtr model_;
};

TEST_F(Flight, FlowIsWhereEachPointOfASurfaceGoes) {
  for (const vision::CameraModel& camera : {kPinhole, Fisheye()}) {
    RayRenderer renderer(model_.get(), camera, {});
    const DataPtr now = StateAt(0), next = StateAt(0.05);
    const cv::Mat flow = renderer.Flow(renderer.Trace(now.get(), CameraAt(0)), {0, now.get(), CameraAt(0)},
                                       {0.05, next.get(), CameraAt(0.05)});
    const cv::Mat truth =
        reference::Flow(model_.get(), now.get(), CameraAt(0), next.get(), CameraAt(0.05), camera);
    ASSERT_EQ(flow.type(), CV_32FC2);
    double longest = 0;
    std::vector<double> errors;
    for (int v = 0; v < flow.rows; ++v) {
      for (int u = 0; u < flow.cols; ++u) {
        const cv::Vec2d is = flow.at<cv::Vec2f>(v, u), should = truth.at<cv::Vec2d>(v, u);
        ASSERT_EQ(std::isnan(is[0]), std::isnan(should[0]))
            << vision::NameOf(camera) << " at " << u << ", " << v;
        if (std::isnan(is[0])) continue;
        errors.push_back(cv::norm(is - should));
        longest = std::max(longest, cv::norm(should));
      }
    }
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() * 999 / 1000], 1e-4)
        << vision::NameOf(camera);  // px; the rest: just on edges
    EXPECT_LT(errors.back(), longest) << vision::NameOf(camera);
    EXPECT_GT(longest, 1) << vision::NameOf(camera);
  }
}

TEST_F(Flight, EachRowOfARollingShutterIsASharpPictureOfItsOwnTime) {
  const double kRow0_s = -0.05, kLine_s = 0.004;
  const DataPtr a = StateAt(-0.1), b = StateAt(0.1), c = StateAt(0.4);
  const std::vector<SceneState> states{
      {-0.1, a.get(), CameraAt(-0.1)}, {0.1, b.get(), CameraAt(0.1)}, {0.4, c.get(), CameraAt(0.4)}};
  for (const vision::CameraModel& camera : {kPinhole, Fisheye()}) {
    RayRenderer renderer(model_.get(), camera, {});
    const cv::Mat rolling =
        renderer.Render(states, {.row_0_s = kRow0_s, .exposure_s = 0, .line_s = kLine_s, .samples = 1});
    cv::Mat rows = rolling.clone();
    for (int v = 0; v < rows.rows; ++v) At(renderer, kRow0_s + v * kLine_s).row(v).copyTo(rows.row(v));
    // Edges are found among the rows of one picture: that alone may differ.
    const ImageDifference difference = Compare(rolling, rows);
    EXPECT_LT(difference.mean, 0.05) << vision::NameOf(camera) << ": " << difference;
    EXPECT_LE(difference.of_99, 1) << vision::NameOf(camera) << ": " << difference;
    EXPECT_GT(Compare(rolling, At(renderer, 0)).mean, 1) << vision::NameOf(camera);
  }
}

TEST_F(Flight, MotionBlurIsTheMeanOfSharpPictures) {
  constexpr double kMiddle_s = 0.02, kExposure_s = 0.1;
  constexpr int kSamples = 6;
  const DataPtr a = StateAt(-0.1), b = StateAt(0.1);
  const std::vector<SceneState> states{{-0.1, a.get(), CameraAt(-0.1)}, {0.1, b.get(), CameraAt(0.1)}};
  for (const vision::CameraModel& camera : {kPinhole, Fisheye()}) {
    RayRenderer renderer(model_.get(), camera, {});
    const cv::Mat blurred = renderer.Render(
        states, {.row_0_s = kMiddle_s, .exposure_s = kExposure_s, .line_s = 0, .samples = kSamples});
    cv::Mat mean = cv::Mat::zeros(blurred.size(), CV_64FC3);
    for (int k = 0; k < kSamples; ++k) {
      cv::Mat sharp;
      At(renderer, kMiddle_s + kExposure_s * ((k + 0.5) / kSamples - 0.5))
          .convertTo(sharp, CV_64F, 1.0 / kSamples);
      mean += sharp;
    }
    mean.convertTo(mean, CV_8U);
    EXPECT_LE(Compare(blurred, mean).most, 1) << vision::NameOf(camera);
    EXPECT_GT(Compare(blurred, At(renderer, kMiddle_s)).of_99, 5) << vision::NameOf(camera);
  }
}

TEST_F(Flight, AnyNumberOfThreadsDrawsTheSameBits) {
  const DataPtr a = StateAt(-0.1), b = StateAt(0.3);
  const std::vector<SceneState> states{{-0.1, a.get(), CameraAt(-0.1)}, {0.3, b.get(), CameraAt(0.3)}};
  const Shutter shutter{.row_0_s = 0, .exposure_s = 0.02, .line_s = 0.003, .samples = 2};
  const auto all = [&](int threads) {
    RayRenderer renderer(model_.get(), Fisheye(), {.threads = threads});
    const Surfaces seen = renderer.Trace(a.get(), states[0].X_NC);
    return std::vector<cv::Mat>{renderer.Render(a.get(), states[0].X_NC), renderer.Render(states, shutter),
                                seen.depth_m, seen.geom, renderer.Flow(seen, states[0], states[1])};
  };
  const std::vector<cv::Mat> alone = all(1);
  for (const int threads : {2, 3, 7, 0}) {
    const std::vector<cv::Mat> together = all(threads);
    for (std::size_t i = 0; i < alone.size(); ++i)
      EXPECT_TRUE(SameBits(together[i], alone[i])) << "output " << i << " on " << threads << " threads";
  }
}

}  // namespace
}  // namespace kestrel::sim
