// SPDX-License-Identifier: Apache-2.0
#include "records/mcap/flight_mcap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "base/mcap/reader.h"
#include "base/ros/annotations.h"
#include "base/ros/sensor_messages.h"
#include "geometry/ros_frames.h"
#include "geometry/tait_bryan.h"
#include "records/mcap/camera_info.h"
#include "tests/support/temporary_folder.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::records {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

vision::Pinhole Camera() {
  vision::Pinhole camera;
  camera.width_px = 64, camera.height_px = 48;
  camera.fx = camera.fy = 50, camera.cx = 31.5, camera.cy = 23.5;
  return camera;
}

// A frame of 0.1 s that came at 0.125 s, over a pad at the origin, heading east.
mission::LogRow Row() {
  mission::LogRow row;
  row.exposure.t_s = 0.1, row.now.t_s = row.estimate.t_s = 0.125;
  row.now.X_NB = {HeadingRotation(M_PI / 2), {1, 2, -3}};
  row.now.v_N = {0, 4, 0};
  row.now.wind_N = {5, 0, -1};
  row.exposure.X_NB = row.now.X_NB;
  row.exposure.X_NC = row.now.X_NB * vision::MountPose({});
  row.estimate.p_NB = {1.1, 2.1, -3.1};
  row.decision.phase = "descend";
  row.decision.target = "tracked";
  return row;
}

class FlightMcapTest : public InTemporaryFolder {
 protected:
  std::filesystem::path file() const { return folder_ / "flight.mcap"; }
  FlightMessageOptions Options(McapImages images = McapImages::kJpeg) const {
    FlightMessageOptions options;
    options.images = images;
    options.camera = Camera();
    options.X_BC = vision::MountPose({});
    options.outline = {{0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}, {-0.5, -0.5}};
    return options;
  }
  // Every message of a topic.
  template <class Message>
  std::vector<Message> All(const std::string& topic) const {
    mcap::Reader reader(file());
    EXPECT_THAT(reader.damage(), IsEmpty());
    reader.Select({topic});
    std::vector<Message> all;
    while (const auto message = reader.Next()) {
      EXPECT_EQ(message->channel->schema.name, Message::kType);
      all.push_back(ros::FromCdr<Message>(message->data));
    }
    return all;
  }
};

TEST_F(FlightMcapTest, LogTimesAreThoseAtWhichAFrameCameAndStampsThoseOfItsExposure) {
  {
    FlightMcap mcap(file(), Options());
    for (int i = 0; i < 5; ++i) {
      mission::LogRow row = Row();
      row.exposure.t_s = 100 + i * 0.0333, row.now.t_s = row.exposure.t_s + 0.025;
      mcap.Write(row, cv::Mat(48, 64, CV_8UC1, cv::Scalar(99)));
    }
    mcap.Close();
  }
  mcap::Reader reader(file());
  reader.Select({"/camera/main/image_raw/compressed"});
  for (std::int64_t i = 0; i < 5; ++i) {
    const auto message = reader.Next();
    ASSERT_TRUE(message);
    EXPECT_EQ(static_cast<std::int64_t>(message->publish_time_ns), 100'000'000'000 + i * 33'300'000);
    EXPECT_EQ(static_cast<std::int64_t>(message->log_time_ns), 100'025'000'000 + i * 33'300'000);
    const auto image = ros::FromCdr<ros::CompressedImage>(message->data);
    EXPECT_EQ(ros::Nanoseconds(image.header.stamp), static_cast<std::int64_t>(message->publish_time_ns));
    EXPECT_EQ(image.header.frame_id, "camera_main");
  }
  EXPECT_FALSE(reader.Next());
}

TEST_F(FlightMcapTest, PosesAreInTheFramesOfRos) {
  {
    FlightMcap mcap(file(), Options());
    mcap.Write(Row(), {});
    mcap.Close();
  }
  const auto truth = All<ros::Odometry>("/truth");
  ASSERT_EQ(truth.size(), 1u);
  EXPECT_EQ(truth[0].header.frame_id, "map");
  EXPECT_EQ(truth[0].child_frame_id, "base_link");
  EXPECT_NEAR(truth[0].pose.translation.x, 2, 1e-12);         // east
  EXPECT_NEAR(truth[0].pose.translation.y, 1, 1e-12);         // north
  EXPECT_NEAR(truth[0].pose.translation.z, 3, 1e-12);         // up
  EXPECT_NEAR(std::abs(truth[0].pose.rotation.w), 1, 1e-12);  // forward is east: x of the map
  EXPECT_NEAR(truth[0].twist.linear.x, 4, 1e-12);             // forward
  const auto wind = All<ros::Vector3Stamped>("/wind");
  ASSERT_EQ(wind.size(), 1u);
  EXPECT_NEAR(wind[0].vector.y, 5, 1e-12);
  EXPECT_NEAR(wind[0].vector.z, 1, 1e-12);
  const auto tf = All<ros::TfMessage>("/tf");
  ASSERT_EQ(tf.size(), 1u);
  ASSERT_EQ(tf[0].transforms.size(), 3u);
  const ros::TransformStamped& camera = tf[0].transforms[1];
  EXPECT_EQ(camera.header.frame_id, "base_link");
  EXPECT_EQ(camera.child_frame_id, "camera_main");
  const ros::Quaternion& q = camera.transform.rotation;
  const Eigen::Quaterniond R(q.w, q.x, q.y, q.z);
  EXPECT_LT((R * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(0, 0, -1)).norm(), 1e-12);  // it looks down
  EXPECT_LT((R * Eigen::Vector3d(0, -1, 0) - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);  // its top is forward
  EXPECT_THAT(All<ros::CompressedImage>("/camera/main/image_raw/compressed"), IsEmpty());
}

TEST_F(FlightMcapTest, RawImagesAreTheSameBytesAndJpegsLookTheSame) {
  cv::Mat wide(48, 80, CV_8UC3);
  for (int y = 0; y < wide.rows; ++y)
    for (int x = 0; x < wide.cols; ++x)
      wide.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<uchar>(2 * x), static_cast<uchar>(4 * y), 40);
  const cv::Mat image = wide.colRange(8, 72);  // whose rows do not follow one another
  for (const McapImages as : {McapImages::kRaw, McapImages::kJpeg}) {
    {
      FlightMcap mcap(file(), Options(as));
      mcap.Write(Row(), image);
      mcap.Close();
    }
    cv::Mat read;
    if (as == McapImages::kRaw) {
      auto raw = All<ros::Image>("/camera/main/image_raw");
      ASSERT_EQ(raw.size(), 1u);
      EXPECT_EQ(raw[0].encoding, "bgr8");
      ASSERT_EQ(raw[0].data.size(), 48u * 64 * 3);
      read = cv::Mat(48, 64, CV_8UC3, raw[0].data.data()).clone();
    } else {
      const auto jpeg = All<ros::CompressedImage>("/camera/main/image_raw/compressed");
      ASSERT_EQ(jpeg.size(), 1u);
      read = cv::imdecode(jpeg[0].data, cv::IMREAD_UNCHANGED);
    }
    ASSERT_EQ(read.size(), image.size());
    EXPECT_LE(cv::norm(read, image, cv::NORM_INF), as == McapImages::kRaw ? 0 : 24);
  }
}

// A camera of 50 px 2 m over a pad of 1 m: 25 px, half of it to each side of the middle.
TEST_F(FlightMcapTest, ThePadIsDrawnWhereTheFixHasIt) {
  mission::LogRow row = Row();
  row.decision.fix = mission::TargetFix{.p_TB = {0, 0, -2.05}};  // the camera is 5 cm below
  {
    FlightMcap mcap(file(), Options());
    mcap.Write(row, cv::Mat(48, 64, CV_8UC1, cv::Scalar(0)));
    mcap.Close();
  }
  const auto drawn = All<ros::ImageAnnotations>("/camera/main/annotations");
  ASSERT_EQ(drawn.size(), 1u);
  EXPECT_EQ(drawn[0].texts.at(0).text, "descend tracked");
  ASSERT_EQ(drawn[0].points.size(), 1u);
  EXPECT_EQ(drawn[0].points[0].type, ros::PointsAnnotation::kLineLoop);
  double left = 1e9, right = -1e9;
  for (const ros::Point2& at : drawn[0].points[0].points)
    left = std::min(left, at.x), right = std::max(right, at.x);
  // From the corner of the image, half a pixel from the centre of its first pixel.
  EXPECT_NEAR(left, 32 - 12.5, 1e-9);
  EXPECT_NEAR(right, 32 + 12.5, 1e-9);
  const auto fix = All<ros::PoseStamped>("/fix");
  ASSERT_EQ(fix.size(), 1u);
  EXPECT_EQ(fix[0].header.frame_id, "pad");
  EXPECT_NEAR(fix[0].pose.translation.z, 2.05, 1e-12);
}

TEST_F(FlightMcapTest, EachKindOfSetpointHasItsTopic) {
  {
    FlightMcap mcap(file(), Options());
    mission::LogRow row = Row();
    for (const control::Setpoint& setpoint :
         {control::Setpoint(control::VelocitySetpoint{{1, 2, 3}, 0.4}),
          control::Setpoint(control::PositionSetpoint{{1, 2, -3}, 0}),
          control::Setpoint(control::AttitudeSetpoint{0.1, 0.2, 0.3, 0.5}),
          control::Setpoint(control::RateSetpoint{{0.1, 0.2, 0.3}, 0.6})}) {
      row.decision.setpoint = setpoint;
      row.now.t_s += 0.01;
      mcap.Write(row, {});
    }
    mcap.WriteEvent(1.5, "phase", "descend");
    mcap.WriteScenario("name: x\n", {{"seed", "3"}});
    mcap.Close();
  }
  const auto velocity = All<ros::TwistStamped>("/setpoint/velocity");
  ASSERT_EQ(velocity.size(), 1u);
  EXPECT_EQ(velocity[0].twist.linear.y, -2);     // to the left
  EXPECT_EQ(velocity[0].twist.angular.z, -0.4);  // anticlockwise
  const auto position = All<ros::PoseStamped>("/setpoint/position");
  ASSERT_EQ(position.size(), 1u);
  EXPECT_EQ(position[0].pose.translation.z, 3);
  const auto attitude = All<ros::AttitudeTarget>("/setpoint/attitude");
  ASSERT_EQ(attitude.size(), 2u);
  EXPECT_EQ(attitude[0].type_mask, 3);
  EXPECT_EQ(attitude[1].type_mask, 128);
  EXPECT_EQ(attitude[1].body_rate.z, -0.3);
  EXPECT_FLOAT_EQ(attitude[1].thrust, 0.6f);
  const auto events = All<ros::Log>("/events");
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].name + ": " + events[0].msg, "phase: descend");
  mcap::Reader reader(file());
  EXPECT_EQ(reader.ReadMetadata("kestrel").at("seed"), "3");
  EXPECT_EQ(reader.ReadAttachment("scenario.yaml")->data, "name: x\n");
}

// By OpenCV, which ROS's own cameras are rectified by.
TEST(CameraInfo, ProjectsAsTheCameraThatItIsOf) {
  vision::BrownConrady brown;
  brown.width_px = 640, brown.height_px = 480, brown.fx = 500, brown.fy = 510, brown.cx = 320, brown.cy = 240;
  brown.k1 = -0.2, brown.k2 = 0.05, brown.p1 = 1e-3, brown.p2 = -2e-3, brown.k3 = 0.01;
  vision::KannalaBrandt fisheye;
  fisheye.width_px = 640, fisheye.height_px = 480, fisheye.fx = 300, fisheye.fy = 305, fisheye.cx = 320,
  fisheye.cy = 240;
  fisheye.k1 = 0.02, fisheye.k2 = -0.004, fisheye.k3 = 0.001, fisheye.k4 = -1e-4;
  std::vector<std::string> models;
  for (const vision::CameraModel& camera :
       {vision::CameraModel(Camera()), vision::CameraModel(brown), vision::CameraModel(fisheye)}) {
    const ros::CameraInfo info = CameraInfoOf(camera);
    models.push_back(info.distortion_model);
    EXPECT_EQ(static_cast<int>(info.width), vision::WidthPx(camera));
    const cv::Mat K(3, 3, CV_64F, const_cast<double*>(info.k.data()));
    for (const Eigen::Vector3d& p_CQ :
         {Eigen::Vector3d(0.1, 0.2, 1), Eigen::Vector3d(-0.4, 0.3, 2), Eigen::Vector3d(0.3, -0.1, 1)}) {
      const std::vector<cv::Point3d> points = {{p_CQ.x(), p_CQ.y(), p_CQ.z()}};
      std::vector<cv::Point2d> seen;
      if (info.distortion_model == "equidistant")
        cv::fisheye::projectPoints(points, seen, cv::Vec3d(), cv::Vec3d(), K, info.d);
      else
        cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), K, info.d, seen);
      const auto uv = vision::Project(camera, p_CQ);
      ASSERT_TRUE(uv);
      EXPECT_NEAR(seen[0].x, uv->x(), 1e-9);
      EXPECT_NEAR(seen[0].y, uv->y(), 1e-9);
    }
  }
  EXPECT_THAT(models, ElementsAre("plumb_bob", "plumb_bob", "equidistant"));
  vision::Unified unified;
  unified.fx = unified.fy = 400, unified.xi = 0.9;
  EXPECT_EQ(CameraInfoOf(unified).distortion_model, "unified");
  EXPECT_EQ(CameraInfoOf(unified).d.size(), vision::ParameterNames(vision::CameraModel(unified)).size() - 4);
}

}  // namespace
}  // namespace kestrel::records
