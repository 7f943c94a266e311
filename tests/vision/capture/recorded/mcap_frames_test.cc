// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/mcap_frames.h"

#include <gtest/gtest.h>

#include <numbers>

#include "base/mcap/writer.h"
#include "base/ros/cdr.h"
#include "base/ros/schemas.h"
#include "base/ros/sensor_messages.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::vision {
namespace {

class McapFramesTest : public InTemporaryFolder {
 protected:
  static std::uint16_t Add(mcap::Writer& writer, const std::string& topic, const char* type) {
    return writer.Add({.topic = topic,
                       .message_encoding = "cdr",
                       .schema = {.name = type, .encoding = "ros2msg", .data = ros::SchemaOf(type)}});
  }
  static ros::TransformStamped Join(const char* parent, const char* child, const Eigen::Quaterniond& R,
                                    const Eigen::Vector3d& p) {
    return {{{}, parent}, child, {{p.x(), p.y(), p.z()}, {R.x(), R.y(), R.z(), R.w()}}};
  }
  std::filesystem::path Write(const std::vector<ros::TransformStamped>& transforms) const {
    mcap::Writer writer(folder_ / "flight.mcap");
    ros::Image image;
    image.header.frame_id = "camera";
    ros::Imu imu;
    imu.header.frame_id = "imu";
    writer.Write(Add(writer, "/cam/image_raw", ros::Image::kType), 1, ros::ToCdr(image));
    writer.Write(Add(writer, "/imu", ros::Imu::kType), 1, ros::ToCdr(imu));
    writer.Write(Add(writer, "/tf_static", ros::TfMessage::kType), 1, ros::ToCdr(ros::TfMessage{transforms}));
    writer.Close();
    return folder_ / "flight.mcap";
  }
};

TEST_F(McapFramesTest, TheTransformsJoinCameraAndImu) {
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ())),
      none(1, 0, 0, 0);
  const auto X_IC = PoseOnImuInMcap(
      Write({Join("map", "base", quarter, {7, 8, 9}), Join("base", "rig", none, {1, 0, 0}),
             Join("rig", "camera", quarter, {0, 2, 0}), Join("base", "imu", quarter, {0, 0, 3})}),
      "/cam/image_raw", "");
  ASSERT_TRUE(X_IC);
  // The camera is at (1, 2, 0) of the base; the IMU at (0, 0, 3), a quarter turned, as the camera is.
  EXPECT_LT(X_IC->R.angularDistance(none), 1e-12);
  EXPECT_LT((X_IC->p - Eigen::Vector3d(2, -1, -3)).norm(), 1e-12);
}

TEST_F(McapFramesTest, FramesThatAreNotJoinedSayNothing) {
  const Eigen::Quaterniond none(1, 0, 0, 0);
  EXPECT_FALSE(PoseOnImuInMcap(Write({}), "/cam/image_raw", ""));
  EXPECT_FALSE(PoseOnImuInMcap(Write({Join("base", "camera", none, {0, 0, 0})}), "/cam/image_raw", ""));
  // Nor do those that go round.
  EXPECT_FALSE(PoseOnImuInMcap(Write({Join("a", "imu", none, {0, 0, 0}), Join("imu", "a", none, {0, 0, 0}),
                                      Join("b", "camera", none, {0, 0, 0})}),
                               "/cam/image_raw", ""));
}

}  // namespace
}  // namespace kestrel::vision
