// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/mcap_images.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "base/mcap/writer.h"
#include "base/ros/cdr.h"
#include "base/ros/schemas.h"
#include "base/ros/sensor_messages.h"
#include "tests/support/temporary_folder.h"
#include "vision/capture/recorded/recorded_gyro.h"

namespace kestrel::vision {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr std::int64_t kFirst_ns = 1700000000123456789;

class McapImagesTest : public InTemporaryFolder {
 protected:
  static mcap::Channel Of(const std::string& topic, const char* type, const std::string& encoding = "cdr") {
    return {.topic = topic,
            .message_encoding = encoding,
            .schema = {.name = type, .encoding = "ros2msg", .data = ros::SchemaOf(type)}};
  }
  static ros::Image Grey(std::int64_t stamp_ns, int grey) {
    ros::Image image;
    image.header = {ros::TimeOf(stamp_ns), "camera"};
    image.height = 6, image.width = 8, image.step = 8;
    image.encoding = "mono8";
    image.data.assign(48, static_cast<std::uint8_t>(grey));
    return image;
  }
  // Three images of one topic, and another topic beside them.
  fs::path Write(const std::vector<std::int64_t>& stamps_ns,
                 const std::vector<std::string>& topics = {"/cam/image_raw"},
                 mcap::Compression compression = mcap::Compression::kZstd) const {
    const fs::path file = folder_ / "flight.mcap";
    mcap::Writer writer(file, {.profile = "ros2", .compression = compression});
    const auto imu = writer.Add(Of("/imu", ros::Imu::kType));
    std::vector<std::uint16_t> cameras;
    for (const std::string& topic : topics) cameras.push_back(writer.Add(Of(topic, ros::Image::kType)));
    for (std::size_t i = 0; i < stamps_ns.size(); ++i) {
      // Logged some time after they were taken.
      const auto logged_ns = static_cast<std::uint64_t>(kFirst_ns) + 50'000'000 * i + 7'000'000;
      for (const std::uint16_t camera : cameras)
        writer.Write(camera, logged_ns, ros::ToCdr(Grey(stamps_ns[i], 10 + static_cast<int>(i))));
      ros::Imu rates;
      rates.header.stamp = ros::TimeOf(stamps_ns[i]);
      rates.angular_velocity = {0.1, -0.2, static_cast<double>(i)};
      writer.Write(imu, logged_ns, ros::ToCdr(rates));
    }
    writer.Close();
    return file;
  }
  static std::vector<std::int64_t> Stamps() {
    return {kFirst_ns, kFirst_ns + 50'000'000, kFirst_ns + 100'000'001};
  }

  static std::vector<int> Greys(const RecordedImages& recorded) {
    const RecordedImages::Reader read = recorded.reader();
    std::vector<int> greys;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      const ImageFile image = read(i, ImageColours::kGrey);
      greys.push_back(image.pixels.empty() ? -1 : image.pixels.at<std::uint8_t>(3, 3));
    }
    return greys;
  }
  static std::string Refusal(const fs::path& file, const std::string& topic = "") {
    Mistakes mistakes;
    EXPECT_EQ(OpenRecordedImages(file, topic, mistakes).size(), 0u);
    return mistakes.empty() ? "accepted" : InputError(mistakes.all()).what();
  }
};

TEST_F(McapImagesTest, TheOnlyTopicIsReadByTheStampsOfItsHeaders) {
  Mistakes mistakes;
  const fs::path file = Write(Stamps());
  const RecordedImages recorded = OpenRecordedImages(file, "", mistakes);
  ASSERT_TRUE(mistakes.empty()) << InputError(mistakes.all()).what();
  EXPECT_EQ(recorded.stamps_ns, Stamps());
  EXPECT_EQ(recorded.topic, "/cam/image_raw");
  EXPECT_EQ(recorded.gyro, file);
  EXPECT_EQ(recorded.note, "");
  EXPECT_THAT(Greys(recorded), ElementsAre(10, 11, 12));
  const RecordedImages::Reader read = recorded.reader();  // backwards too
  EXPECT_EQ(read(2, ImageColours::kColour).pixels.at<cv::Vec3b>(0, 0), cv::Vec3b(12, 12, 12));
  EXPECT_EQ(read(0, ImageColours::kGrey).pixels.at<std::uint8_t>(0, 0), 10);
}

TEST_F(McapImagesTest, OfSeveralTopicsOneIsNamed) {
  const fs::path file = Write(Stamps(), {"/left/image_raw", "/right/image_raw"});
  EXPECT_THAT(Refusal(file), HasSubstr("valid: /left/image_raw, /right/image_raw"));
  EXPECT_THAT(Refusal(file, "/left/image_rew"), HasSubstr("did you mean /left/image_raw?"));
  EXPECT_THAT(Refusal(file, "/imu"), HasSubstr("no topic '/imu' of it has images"));
  Mistakes mistakes;
  EXPECT_EQ(OpenRecordedImages(file, "/right/image_raw", mistakes).topic, "/right/image_raw");
  EXPECT_TRUE(mistakes.empty());
}

TEST_F(McapImagesTest, ItsImuIsAGyroOfTheSameClock) {
  Mistakes mistakes;
  const std::vector<RecordedRate> rates = ReadRecordedGyro(Write(Stamps()), "", mistakes);
  ASSERT_TRUE(mistakes.empty()) << InputError(mistakes.all()).what();
  ASSERT_EQ(rates.size(), 3u);
  EXPECT_EQ(rates[2].stamp_ns, Stamps()[2]);
  EXPECT_EQ(rates[2].w_I, Eigen::Vector3d(0.1, -0.2, 2));
  EXPECT_TRUE(ReadRecordedGyro(Write(Stamps()), "/imu2", mistakes).empty());
  EXPECT_THAT(InputError(mistakes.all()).what(), HasSubstr("valid: /imu"));
}

TEST_F(McapImagesTest, StampsThatGoBackOrRepeatAreToldByTheirMessages) {
  EXPECT_THAT(Refusal(Write({kFirst_ns, kFirst_ns, kFirst_ns - 5, kFirst_ns + 9})),
              AllOf(HasSubstr("message 2 of /cam/image_raw: the stamp 1700000000123456789 comes twice"),
                    HasSubstr("message 3 of /cam/image_raw: the stamp 1700000000123456784 goes back")));
}

TEST_F(McapImagesTest, WithoutStampsWhenTheyWereLoggedIsTakenAndTold) {
  Mistakes mistakes;
  const RecordedImages recorded = OpenRecordedImages(Write({0, 0}), "", mistakes);
  EXPECT_THAT(recorded.stamps_ns, ElementsAre(kFirst_ns + 7'000'000, kFirst_ns + 57'000'000));
  EXPECT_THAT(recorded.note, HasSubstr("have no stamps"));
}

TEST_F(McapImagesTest, AFileWithoutImagesOrMessagesIsRefused) {
  EXPECT_THAT(Refusal(Write(Stamps(), {})),
              AllOf(HasSubstr("has images"), HasSubstr("/imu (sensor_msgs/msg/Imu)")));
  const fs::path file = folder_ / "empty.mcap";
  mcap::Writer writer(file);
  const auto camera = writer.Add(Of("/cam", ros::Image::kType));
  const auto imu = writer.Add(Of("/imu", ros::Imu::kType));
  writer.Write(imu, 5, ros::ToCdr(ros::Imu()));
  writer.Close();
  (void)camera;
  EXPECT_NE(Refusal(file), "accepted");
  std::ofstream(folder_ / "none.mcap") << "no mcap";
  EXPECT_THAT(Refusal(folder_ / "none.mcap"), HasSubstr("valid: an MCAP"));
}

TEST_F(McapImagesTest, CompressedImagesAreDecodedAndDepthIsRefused) {
  const fs::path file = folder_ / "flight.mcap";
  cv::Mat wide(24, 32, CV_8UC3, cv::Scalar(10, 120, 200));
  mcap::Writer writer(file);
  const auto camera = writer.Add(Of("/cam/image_raw/compressed", ros::CompressedImage::kType));
  std::vector<std::string> formats = {"jpeg", "bgr8; png compressed bgr8", "16UC1; compressedDepth png"};
  for (std::size_t i = 0; i < formats.size(); ++i) {
    ros::CompressedImage image;
    image.header.stamp = ros::TimeOf(static_cast<std::int64_t>(i) + 1);
    image.format = formats[i];
    cv::imencode(i == 0 ? ".jpg" : ".png", wide, image.data);
    writer.Write(camera, i + 1, ros::ToCdr(image));
  }
  writer.Close();
  Mistakes mistakes;
  const RecordedImages recorded = OpenRecordedImages(file, "", mistakes);
  ASSERT_EQ(recorded.size(), 3u);
  const auto read = recorded.reader();
  EXPECT_NEAR(read(0, ImageColours::kColour).pixels.at<cv::Vec3b>(9, 9)[1], 120, 3);
  EXPECT_EQ(read(1, ImageColours::kColour).pixels.at<cv::Vec3b>(9, 9), cv::Vec3b(10, 120, 200));
  EXPECT_THAT(read(2, ImageColours::kColour).error, HasSubstr("compressedDepth"));
}

TEST_F(McapImagesTest, ACameraInfoBesideTheImagesIsTheirCalibration) {
  const fs::path file = folder_ / "flight.mcap";
  mcap::Writer writer(file);
  const auto camera = writer.Add(Of("/cam/image_raw", ros::Image::kType));
  const auto info = writer.Add(Of("/cam/camera_info", ros::CameraInfo::kType));
  writer.Write(camera, 1, ros::ToCdr(Grey(1, 1)));
  ros::CameraInfo calibration;
  calibration.height = 6, calibration.width = 8, calibration.distortion_model = "plumb_bob";
  calibration.k = {5, 0, 3.5, 0, 6, 2.5, 0, 0, 1};
  calibration.d = {0.1, 0, 0, 0, 0};
  writer.Write(info, 1, ros::ToCdr(calibration));
  writer.Close();
  Mistakes mistakes;
  EXPECT_THAT(OpenRecordedImages(file, "", mistakes).calibration_text,
              AllOf(HasSubstr("image_width: 8"), HasSubstr("K: [5, 0, 3.5, 0, 6, 2.5, 0, 0, 1]"),
                    HasSubstr("distortion_model: plumb_bob")));
}

// Cut shorter and shorter: what is whole is read, and that something is missing is told from the first byte on.
TEST_F(McapImagesTest, CutAnywhereItGivesWhatIsWholeAndSaysThatTheRestIsMissing) {
  for (const auto compression : {mcap::Compression::kNone, mcap::Compression::kLz4}) {
    const fs::path cut = Write(Stamps(), {"/cam/image_raw"}, compression);
    std::size_t before = 3, told = 0, read = 0;
    for (std::uintmax_t size = fs::file_size(cut) - 1; size > 0;
         size -= std::min<std::uintmax_t>(size, 1 + size % 5)) {
      fs::resize_file(cut, size);
      Mistakes mistakes;
      const RecordedImages recorded = OpenRecordedImages(cut, "", mistakes);
      ASSERT_NE(mistakes.empty(), recorded.size() == 0) << size;
      ASSERT_LE(recorded.size(), before) << size;
      before = recorded.size();
      for (std::size_t i = 0; i < recorded.size(); ++i) ASSERT_EQ(recorded.stamps_ns[i], Stamps()[i]);
      if (recorded.size() == 0) continue;
      ++read, told += recorded.note.find("the rest is missing") != std::string::npos;
      if (recorded.size() == 3 && read % 16 == 0) {
        ASSERT_THAT(Greys(recorded), ElementsAre(10, 11, 12)) << size;
      }
    }
    EXPECT_EQ(before, 0u);
    EXPECT_EQ(told, read);
    EXPECT_GT(read, 100u);
  }
}

}  // namespace
}  // namespace kestrel::vision
