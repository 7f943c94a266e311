// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/frame_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "geometry/tait_bryan.h"
#include "sim/simulator.h"
#include "sim/world/frames.h"

namespace kestrel::sim {
namespace {

constexpr double kStep_s = 0.002;
constexpr double kHeight_m = 5;
const vision::Pinhole kCamera{160, 96, 200, 200, 79.5, 47.5};

// A camera that looks straight down from 5 m, its top to the north, on a bright slab that covers the east of
// dark ground; both the camera and the slab can move eastwards.
class StudioTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* xml = R"(<mujoco>
        <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
        <worldbody>
          <body name="vehicle"><freejoint/><geom size="0.001" rgba="0 0 0 0"/></body>
          <geom type="box" size="50 50 0.1" pos="0 0 -0.2" rgba="0.2 0.2 0.2 1"/>
          <body name="slab" mocap="true">
            <geom type="box" size="40 40 0.01" pos="0 -40 -0.01" rgba="0.8 0.8 0.8 1" contype="0"/>
          </body>
        </worldbody></mujoco>)";
    mjVFS files;
    mj_defaultVFS(&files);
    mj_makeEmptyFileVFS(&files, "m.xml", static_cast<int>(std::strlen(xml)));
    std::memcpy(files.filedata[0], xml, std::strlen(xml));
    char error[500] = "";
    model_.reset(mj_loadXML("m.xml", &files, error, sizeof error));
    mj_deleteVFS(&files);
    ASSERT_TRUE(model_) << error;
    image_.noise_grey = 0;
  }

  // Of a middle at t_s, with the places of camera and slab as functions of time, m east.
  using Way = std::function<double(double)>;
  FrameRequest ShotOf(double t_s, const Way& camera, const Way& slab, std::int64_t sequence = 0) const {
    FrameRequest request;
    request.t_s = t_s, request.sequence = sequence;
    const DataPtr data = MakeData(model_.get());
    for (int i = -30; i <= 30; ++i) {
      const double t = t_s + kStep_s * i;
      PoseToMujoco({Eigen::Quaterniond::Identity(), {0, camera(t), -kHeight_m}}, data->qpos);
      data->mocap_pos[1] = -slab(t);
      request.snapshots.push_back(SnapshotOf(model_.get(), data.get(), t));
    }
    return request;
  }
  cv::Mat Picture(const FrameRequest& request) const {
    FrameRenderer renderer(model_.get(), kCamera, {}, image_, vision::MountPose({{0, 0, 0}, 0, 0, 0}),
                           Vibration({}, 1), 1);
    renderer.Submit(request);
    return renderer.Next().image;
  }
  // How far a row has come from dark to bright in each of its pixels.
  static std::vector<double> Profile(const cv::Mat& image, int row) {
    const double dark = image.at<std::uint8_t>(row, 2), bright = image.at<std::uint8_t>(row, image.cols - 3);
    EXPECT_GT(bright, 2 * dark);
    std::vector<double> profile;
    for (int x = 0; x < image.cols; ++x)
      profile.push_back((image.at<std::uint8_t>(row, x) - dark) / (bright - dark));
    return profile;
  }
  // Where its edge is, by the light to the right of it.
  static double Edge(const cv::Mat& image, int row) {
    double light = 0;
    for (const double share : Profile(image, row)) light += share;
    return image.cols - 0.5 - light;
  }
  static double Still(double) { return 0; }

  ModelPtr model_;
  ImageParameters image_;
};

// The camera goes 0.1 m east between two shots, and later the slab with it; each request also knows how far away
// everything is.
TEST_F(StudioTest, SurveysWhatIsThereAndHowItMovedSinceTheShotBefore) {
  image_.exposure.time_s = 0.01, image_.exposure.line_s = 1e-5;
  FrameRenderer renderer(model_.get(), kCamera, {}, image_, vision::MountPose({{0, 0, 0}, 0, 0, 0}),
                         Vibration({}, 1), 1, true);
  const Way east = [](double t) { return t - 3; };
  renderer.Submit(ShotOf(3, east, Still));
  renderer.Submit(ShotOf(3.1, east, Still, 1));
  renderer.Submit(ShotOf(3.2, east, east, 2));
  const kestrel::sim::RenderedFrame first = renderer.Next(), second = renderer.Next(),
                                    third = renderer.Next();
  EXPECT_TRUE(first.flow_here.empty());
  const cv::Point ground(10, 47), slab(150, 47);
  const double across = 1 / vision::Ray(kCamera, {10, 47})->z();
  EXPECT_NEAR(first.surfaces.depth_m.at<float>(ground), (kHeight_m + 0.1) * across, 1e-4);
  EXPECT_NEAR(first.surfaces.depth_m.at<float>(slab), kHeight_m / vision::Ray(kCamera, {150, 47})->z(), 1e-4);
  EXPECT_EQ(first.surfaces.geom.at<int>(ground), 0);  // those of the world come first
  EXPECT_EQ(first.surfaces.geom.at<int>(slab), 2);
  EXPECT_NEAR(second.flow_here.at<cv::Vec2f>(ground)[0], -200 * 0.1 / (kHeight_m + 0.1), 1e-3);
  EXPECT_NEAR(second.flow_here.at<cv::Vec2f>(slab)[0], -200 * 0.1 / kHeight_m, 1e-3);
  EXPECT_NEAR(third.flow_here.at<cv::Vec2f>(slab)[0], 200 * (0.2 - 0.1) / kHeight_m, 1e-3);
}

TEST_F(StudioTest, AnInstantIsSharp) {
  const cv::Mat image = Picture(ShotOf(
      3, [](double t) { return 10 * (t - 3); }, Still));
  for (const int row : {5, 50, 90}) {
    const std::vector<double> profile = Profile(image, row);
    EXPECT_LT(profile[78], 0.01);
    EXPECT_GT(profile[81], 0.99);
  }
}

// An edge that moves evenly by b pixels while the shutter is open becomes a ramp of b pixels: its step,
// spread by a box.
TEST_F(StudioTest, AMovingCameraAndAMovingTargetSmearAnEdgeIntoARamp) {
  image_.exposure.time_s = 0.03, image_.exposure.samples = 64;
  constexpr double kSpeed_m_s = 12, kRamp_px = 200 / kHeight_m * kSpeed_m_s * 0.03;
  const Way east = [](double t) { return kSpeed_m_s * (t - 3); };
  for (const FrameRequest& request : {ShotOf(3, east, Still), ShotOf(3, Still, east)}) {
    const cv::Mat image = Picture(request);
    for (const int row : {5, 50, 90}) {
      const std::vector<double> profile = Profile(image, row);
      for (int x = 0; x < image.cols; ++x) {
        // A pixel's own width rounds the two ends of the ramp; 64 samples and 256 levels are its steps.
        const double wanted = std::clamp((x - 79.5) / kRamp_px + 0.5, 0.0, 1.0);
        EXPECT_NEAR(profile[x], wanted, 0.045) << x;
      }
    }
  }
}

TEST_F(StudioTest, TheBlurIsAsManySharpImagesOnTopOfEachOther) {
  image_.exposure.time_s = 0.02, image_.exposure.samples = 5;
  const Way camera = [](double t) { return 15 * (t - 3); },
            slab = [](double t) { return 4 * std::sin(9 * (t - 3)); };
  const cv::Mat blurred = Picture(ShotOf(3, camera, slab));
  image_.exposure.time_s = 0;
  cv::Mat sum(blurred.size(), CV_64F, cv::Scalar(0)), mean;
  for (int k = 0; k < 5; ++k) {
    cv::Mat sharp;
    Picture(ShotOf(3 + 0.02 * ((k + 0.5) / 5 - 0.5), camera, slab)).convertTo(sharp, CV_64F);
    sum += sharp / 5;
  }
  sum.convertTo(mean, CV_8U);
  EXPECT_GT(cv::norm(blurred, Picture(ShotOf(3, camera, slab)), cv::NORM_INF), 50);
  cv::Mat difference;
  cv::absdiff(blurred, mean, difference);
  // Sway between two steps is drawn as even motion: an edge pixel may fall on the other side.
  EXPECT_LT(cv::countNonZero(difference > 1), 0.01 * difference.total());
}

// Each row sees the edge where it is when the row is exposed; the middle row at the time of the frame.
TEST_F(StudioTest, ARollingShutterSlantsAnEdgeThatMoves) {
  image_.exposure.line_s = 0.0004;
  constexpr double kSpeed_m_s = 8, kSlant = 200 / kHeight_m * kSpeed_m_s * 0.0004;  // px for each row
  const Way east = [](double t) { return kSpeed_m_s * (t - 3); };
  for (const double sign : {1.0, -1.0}) {
    const cv::Mat image = Picture(sign > 0 ? ShotOf(3, east, Still) : ShotOf(3, Still, east));
    for (int row = 0; row < image.rows; ++row) {
      // The camera's way east moves the edge to the left. Rows may be drawn in bands, whose middle then
      // counts, and an edge falls on whole pixels.
      EXPECT_NEAR(Edge(image, row), 79.5 - sign * kSlant * (row - 47.5), 0.5 + 8 * kSlant) << row;
    }
    EXPECT_NEAR(Edge(image, 0) + Edge(image, 95), 2 * 79.5, 1.01);
    EXPECT_GT(std::abs(Edge(image, 0) - Edge(image, 95)), 70 * kSlant);
  }
}

TEST_F(StudioTest, AutoExposureShortensTheSmearOfABrightScene) {
  image_.exposure.time_s = 0.02, image_.exposure.samples = 32;
  image_.auto_exposure.target_grey = 40;
  image_.auto_exposure.lag_s = 0;
  const auto draw = [&](FrameRenderer& renderer, int sequence) {
    const double t = 3 + 0.05 * sequence;
    renderer.Submit(ShotOf(
        t, [&](double s) { return 12 * (s - t); }, Still, sequence));
    return renderer.Next().image;
  };
  const auto ramp_px = [](const cv::Mat& image) {
    int width = 0;
    for (const double share : Profile(image, 50)) width += share > 0.05 && share < 0.95;
    return width / 0.9;
  };
  FrameRenderer renderer(model_.get(), kCamera, {}, image_, vision::MountPose({{0, 0, 0}, 0, 0, 0}),
                         Vibration({}, 1), 1);
  const cv::Mat first = draw(renderer, 0);
  cv::Mat last;
  for (int k = 1; k < 8; ++k) last = draw(renderer, k);
  EXPECT_NEAR(cv::mean(last)[0], 40, 1);
  EXPECT_NEAR(ramp_px(first), 9.6, 1.2);
  EXPECT_NEAR(ramp_px(last) / ramp_px(first), 40 / cv::mean(first)[0], 0.15);
}

}  // namespace
}  // namespace kestrel::sim
