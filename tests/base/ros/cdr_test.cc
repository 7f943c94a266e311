// SPDX-License-Identifier: Apache-2.0
// Bytes by the definition of CDR, written here by hand; what others read of it, tests/peers/mcap tells.
#include "base/ros/cdr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "base/ros/annotations.h"
#include "base/ros/schemas.h"
#include "base/ros/sensor_messages.h"

namespace kestrel::ros {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using namespace std::string_literals;

TEST(Cdr, IsAsItsDefinitionHasIt) {
  CompressedImage image;
  image.header = {{1, 2}, "cam"};
  image.format = "jpeg";
  image.data = {0xff, 0xd8};
  EXPECT_EQ(ToCdr(image),
            "\x00\x01\x00\x00"  // plain CDR, little-endian
            "\x01\x00\x00\x00"  // sec
            "\x02\x00\x00\x00"  // nanosec
            "\x04\x00\x00\x00"
            "cam\0"  // with its null
            "\x05\x00\x00\x00"
            "jpeg\0"
            "\x00\x00\x00"  // to a multiple of 4
            "\x02\x00\x00\x00"
            "\xff\xd8"s);
}

TEST(Cdr, NumbersStandAtMultiplesOfTheirSizeFromBehindTheHead) {
  AttitudeTarget target;
  target.header = {{0, 0}, ""};
  target.type_mask = 7;
  target.orientation = {1, 0, 0, 0};
  const std::string bytes = ToCdr(target);
  EXPECT_EQ(bytes[4 + 13], 7);                                  // behind the time, a length of 1 and the null
  EXPECT_EQ(bytes.substr(4 + 14, 2), "\0\0"s);                  // to 16
  EXPECT_EQ(bytes.substr(4 + 16, 8), "\0\0\0\0\0\0\xf0\x3f"s);  // 1.0
  EXPECT_EQ(bytes.size(), 4 + 16 + 7 * 8 + 4u);
}

TEST(Cdr, GivesBackWhatWasWritten) {
  CameraInfo info;
  info.header = {TimeOf(-1), "camera"};
  info.height = 480, info.width = 640;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, -0.2, 0.001, 0.002, 0.3};
  info.k[0] = 500, info.p[11] = 7;
  info.roi.do_rectify = true;
  const CameraInfo back = FromCdr<CameraInfo>(ToCdr(info));
  EXPECT_EQ(Nanoseconds(back.header.stamp), -1);
  EXPECT_EQ(back.header.frame_id, "camera");
  EXPECT_EQ(back.width, 640u);
  EXPECT_EQ(back.distortion_model, "plumb_bob");
  EXPECT_EQ(back.d, info.d);
  EXPECT_EQ(back.k, info.k);
  EXPECT_EQ(back.p, info.p);
  EXPECT_TRUE(back.roi.do_rectify);

  ImageAnnotations drawn;
  drawn.points.push_back(
      {{3, 4}, PointsAnnotation::kLineLoop, {{1, 2}, {3, 4}, {5, 6}}, {0, 1, 0, 1}, {}, {}, 2});
  drawn.texts.push_back({{3, 4}, {1, 2}, "pad", 14, {}, {}});
  const ImageAnnotations seen = FromCdr<ImageAnnotations>(ToCdr(drawn));
  ASSERT_EQ(seen.points.size(), 1u);
  EXPECT_EQ(seen.points[0].points[2].y, 6);
  EXPECT_EQ(seen.texts.at(0).text, "pad");
}

TEST(Cdr, CutAnywhereOrOfMadeUpLengthsItIsRefused) {
  TfMessage message;
  message.transforms.resize(3);
  message.transforms[1].child_frame_id = "base_link";
  const std::string bytes = ToCdr(message);
  for (std::size_t cut = 0; cut < bytes.size(); ++cut)
    EXPECT_THROW(FromCdr<TfMessage>(bytes.substr(0, cut)), CdrError) << cut;
  std::string many = bytes;
  many.replace(4, 4, "\xff\xff\xff\xff");
  EXPECT_THROW(FromCdr<TfMessage>(many), CdrError);
  std::string image = ToCdr(Image{});
  image.replace(image.size() - 4, 4, "\xff\xff\xff\x7f");
  EXPECT_THROW(FromCdr<Image>(image), CdrError);
  EXPECT_THROW(FromCdr<Image>("\x00\x00\x00\x00 of the other order"s), CdrError);
}

TEST(RosTime, IsExactBothWays) {
  for (const std::int64_t ns :
       {0L, 1L, 999'999'999L, 1'000'000'000L, 1'700'000'000'123'456'789L, -1L, -1'000'000'000L}) {
    EXPECT_EQ(Nanoseconds(TimeOf(ns)), ns);
    EXPECT_LT(TimeOf(ns).nanosec, 1'000'000'000u);
  }
}

TEST(RosSchemas, NameAllThatTheyAreMadeOfOnce) {
  const std::string schema = SchemaOf(Odometry::kType);
  EXPECT_THAT(schema, StartsWith("std_msgs/Header header\nstring child_frame_id\n"));
  for (const char* part : {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/PoseWithCovariance",
                           "geometry_msgs/Point", "geometry_msgs/Vector3", "geometry_msgs/Quaternion"}) {
    const std::string line = "\nMSG: "s + part + "\n";
    ASSERT_THAT(schema, HasSubstr(line));
    EXPECT_EQ(schema.find(line), schema.rfind(line));
  }
  EXPECT_THROW(SchemaOf("sensor_msgs/msg/PointCloud2"), std::logic_error);
}

}  // namespace
}  // namespace kestrel::ros
