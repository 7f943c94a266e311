// SPDX-License-Identifier: Apache-2.0
// One flight, recorded in each form that the verbs read.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <vector>

#include "app/simulated/horizon_command.h"
#include "app/simulated/track_command.h"
#include "base/diagnostics.h"
#include "base/mcap/writer.h"
#include "base/ros/cdr.h"
#include "base/ros/schemas.h"
#include "base/ros/sensor_messages.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

// A camera of 320 x 240 pixels that looks down on a picture of 0.4 m by 0.5 m from 1 m, and drifts.
class RecordedInputTest : public InTemporaryFolder {
 protected:
  static constexpr int kImages = 4;
  static std::int64_t StampOf(int i) { return 1403636579763555584 + i * 50'000'000LL + (i == 2) * 128; }

  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::ofstream(folder_ / "camera.yaml")
        << "model: brown_conrady\nk1: 0\nk2: 0\np1: 0\np2: 0\nwidth_px: 320\nheight_px: 240\nfx_px: "
           "400\nfy_px: 400\ncx_px: 159.5\ncy_px: 119.5\n";
    cv::Mat blocks(16, 20, CV_8UC1), picture, small;
    cv::RNG(4).fill(blocks, cv::RNG::UNIFORM, 0, 256);
    cv::resize(blocks, picture, {500, 400}, 0, 0, cv::INTER_NEAREST);
    cv::imwrite(folder_ / "picture.png", picture);
    cv::resize(picture, small, {200, 160}, 0, 0, cv::INTER_AREA);
    for (int i = 0; i < kImages; ++i) {
      cv::Mat image(240, 320, CV_8UC1, cv::Scalar(120));
      small.copyTo(image(cv::Rect(50 + 3 * i, 40 + i, 200, 160)));
      images_.push_back(image);
    }
    arguments_.landmark = (folder_ / "picture.png").string();
    arguments_.size_m = {0.4, 0.5};
    arguments_.csv = (folder_ / "out.csv").string();
    arguments_.quiet = true;
  }

  void WriteImage(const fs::path& file, int i) const {
    fs::create_directories(file.parent_path());
    cv::imwrite(file, images_[static_cast<std::size_t>(i)]);
  }
  void WriteEuroc(const fs::path& folder) const {
    std::ostringstream table;
    table << "#timestamp [ns],filename\n";
    for (int i = 0; i < kImages; ++i) {
      WriteImage(folder / "mav0/cam0/data" / fmt::format("{}.png", StampOf(i)), i);
      table << StampOf(i) << ',' << StampOf(i) << ".png\n";
    }
    std::ofstream(folder / "mav0/cam0/data.csv") << table.str();
    std::ofstream(folder / "mav0/cam0/sensor.yaml")
        << "sensor_type: camera\nresolution: [320, 240]\ncamera_model: pinhole\nintrinsics: [400, 400, "
           "159.5, 119.5]\n"
           "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";
  }

  static mcap::Channel Of(const std::string& topic, const char* type) {
    return {.topic = topic,
            .message_encoding = "cdr",
            .schema = {.name = type, .encoding = "ros2msg", .data = ros::SchemaOf(type)}};
  }
  void WriteMcap(const fs::path& file) const {
    mcap::Writer writer(file, {.profile = "ros2"});
    const auto info = writer.Add(Of("/cam/camera_info", ros::CameraInfo::kType)),
               camera = writer.Add(Of("/cam/image_raw", ros::Image::kType));
    ros::CameraInfo calibration;
    calibration.width = 320, calibration.height = 240, calibration.distortion_model = "plumb_bob";
    calibration.k = {400, 0, 159.5, 0, 400, 119.5, 0, 0, 1}, calibration.d = {0, 0, 0, 0, 0};
    writer.Write(info, static_cast<std::uint64_t>(StampOf(0)), ros::ToCdr(calibration));
    for (int i = 0; i < kImages; ++i) {
      const cv::Mat& grey = images_[static_cast<std::size_t>(i)];
      ros::Image image;
      image.header.stamp = ros::TimeOf(StampOf(i));
      image.width = 320, image.height = 240, image.step = 320, image.encoding = "mono8";
      image.data.assign(grey.datastart, grey.dataend);
      writer.Write(camera, static_cast<std::uint64_t>(StampOf(i)), ros::ToCdr(image));
    }
    writer.Close();
  }

  // The rows of the table without what a clock measured.
  std::vector<std::string> Rows() const {
    std::vector<std::string> rows;
    std::ifstream csv(arguments_.csv);
    for (std::string line; std::getline(csv, line);) {
      line.resize(line.rfind(','));
      line.resize(line.rfind(','));
      rows.push_back(line);
    }
    return rows;
  }
  std::vector<std::string> Track(const fs::path& input, const std::string& camera = "camera.yaml") {
    arguments_.input = input.string();
    arguments_.camera = camera.empty() ? "" : (folder_ / camera).string();
    TrackCommand(arguments_);
    return Rows();
  }
  std::string Refusal() const {
    try {
      TrackCommand(arguments_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }

  std::vector<cv::Mat> images_;
  TrackArguments arguments_;
};

TEST_F(RecordedInputTest, AFlightIsTrackedTheSameInEachForm) {
  WriteEuroc(folder_ / "euroc");
  std::ofstream rgb, times;
  for (int i = 0; i < kImages; ++i) {
    WriteImage(folder_ / "ns" / fmt::format("{}.png", StampOf(i)), i);
    WriteImage(folder_ / "tum/rgb" / fmt::format("{}.png", i), i);
    WriteImage(folder_ / "kitti/image_0" / fmt::format("{:06}.png", i), i);
    if (i == 0) rgb.open(folder_ / "tum/rgb.txt"), times.open(folder_ / "kitti/times.txt");
    const std::string stamp = fmt::format("{}.{:09}", StampOf(i) / 1000000000, StampOf(i) % 1000000000);
    rgb << stamp << " rgb/" << i << ".png\n";
    times << stamp << '\n';
  }
  rgb.close(), times.close();
  const std::vector<std::string> rows = Track(folder_ / "euroc");
  ASSERT_EQ(rows.size(), kImages + 1u);
  EXPECT_THAT(rows[1], ::testing::StartsWith("0,0.000000000,found"));
  EXPECT_THAT(rows[2], ::testing::StartsWith("1,0.050000000,"));
  EXPECT_THAT(rows[3], ::testing::StartsWith("2,0.100000128,"));  // to the nanosecond
  EXPECT_EQ(Track(folder_ / "euroc", ""), rows);                  // by its own calibration
  WriteMcap(folder_ / "flight.mcap");
  EXPECT_EQ(Track(folder_ / "flight.mcap"), rows);
  EXPECT_EQ(Track(folder_ / "flight.mcap", ""), rows);  // by its camera_info
  EXPECT_EQ(Track("file:" + (folder_ / "flight.mcap").string() + "?topic=/cam/image_raw"), rows);
  for (const char* form : {"euroc/mav0", "euroc/mav0/cam0", "ns", "tum", "kitti", "kitti/image_0"})
    EXPECT_EQ(Track(folder_ / form), rows) << form;
  EXPECT_EQ(Track("file:" + (folder_ / "euroc").string() + "?topic=cam0"), rows);
}

TEST_F(RecordedInputTest, ImagesWithoutStampsComeAtTheRateThatIsGiven) {
  for (int i = 0; i < kImages; ++i) WriteImage(folder_ / "numbers" / fmt::format("{}.png", i), i);
  arguments_.rate_hz = 8;
  EXPECT_THAT(Track(folder_ / "numbers")[4], ::testing::StartsWith("3,0.375000000,"));
}

TEST_F(RecordedInputTest, WhatIsWrongWithARecordingIsTold) {
  WriteEuroc(folder_ / "euroc");
  arguments_.input = (folder_ / "euroc").string();
  arguments_.topic = "cam7", arguments_.rate_hz = 20;
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("cam7"), HasSubstr("valid: cam0")));
  arguments_.topic = "";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--rate"), HasSubstr("stamps of their own")));
  arguments_.rate_hz.reset();
  fs::remove(folder_ / "euroc/mav0/cam0/sensor.yaml");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--camera"), HasSubstr("no calibration of its own")));
  fs::remove(folder_ / "euroc/mav0/cam0/data" / fmt::format("{}.png", StampOf(1)));
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("data.csv:3"), HasSubstr("its image is missing")));
  arguments_.input = (folder_ / "picture.png").string();
  arguments_.topic = "cam0";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--topic"), HasSubstr("no recording")));
}

TEST_F(RecordedInputTest, ATruncatedImageIsARowThatSaysSo) {
  WriteEuroc(folder_ / "euroc");
  const fs::path file = folder_ / "euroc/mav0/cam0/data" / fmt::format("{}.png", StampOf(1));
  fs::resize_file(file, fs::file_size(file) / 2);
  HorizonArguments horizon;
  horizon.input = (folder_ / "euroc").string();
  horizon.csv = arguments_.csv, horizon.quiet = true;
  HorizonCommand(horizon);
  std::ifstream csv(horizon.csv);
  std::string line;
  for (int i = 0; i < 3; ++i) std::getline(csv, line);
  EXPECT_EQ(line, "1,0.050000000,,,,,,,,,unreadable");
  int rows = 3;
  while (std::getline(csv, line)) ++rows;
  EXPECT_EQ(rows, kImages + 1);
}

}  // namespace
}  // namespace kestrel::app
