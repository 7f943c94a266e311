// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/opencv_source.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "base/stopwatch.h"
#include "vision/capture/live_camera.h"

namespace kestrel::vision {
namespace {

using Kind = OpenCvSourceOptions::Kind;

// A folder with three images of their own grey levels.
class OpenCvSourceTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    for (int i = 0; i < 3; ++i)
      cv::imwrite(folder_ / ("image" + std::to_string(i) + ".png"),
                  cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(50 * i + 20)));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  OpenCvSourceOptions Folder() const {
    OpenCvSourceOptions options;
    options.kind = Kind::kFile, options.what = folder_ / "image%d.png";
    return options;
  }
  std::filesystem::path folder_;
};

TEST_F(OpenCvSourceTest, AFolderOfImagesComesOneByOneAndEnds) {
  const auto source = OpenCvSource(Folder())();
  ASSERT_TRUE(source->Open());
  for (int i = 0; i < 3; ++i) {
    const auto grabbed = source->Grab();
    ASSERT_TRUE(grabbed) << i;
    ASSERT_EQ(grabbed->image.type(), CV_8UC1);
    EXPECT_EQ(grabbed->image.at<std::uint8_t>(5, 5), 50 * i + 20);
    EXPECT_NEAR(MonotonicNow_s() - *grabbed->stamp_s, 0, 1);
  }
  EXPECT_FALSE(source->Grab());
  EXPECT_TRUE(source->Ended());
}

TEST_F(OpenCvSourceTest, ColourIsGivenWhereItIsAskedFor) {
  OpenCvSourceOptions options = Folder();
  options.colour = true;
  const auto source = OpenCvSource(options)();
  ASSERT_TRUE(source->Open());
  EXPECT_EQ(source->Grab()->image.type(), CV_8UC3);
}

TEST_F(OpenCvSourceTest, AnImageOfAnotherSizeIsAFailure) {
  OpenCvSourceOptions options = Folder();
  options.size = {640, 480};
  const auto source = OpenCvSource(options)();
  ASSERT_TRUE(source->Open());
  EXPECT_FALSE(source->Grab());
}

TEST_F(OpenCvSourceTest, AFileIsReadAtItsPace) {
  OpenCvSourceOptions options = Folder();
  options.rate_hz = 50;
  const auto source = OpenCvSource(options)();
  ASSERT_TRUE(source->Open());
  const double begun_s = MonotonicNow_s();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(source->Grab());
  EXPECT_GE(MonotonicNow_s() - begun_s, 0.039);
}

TEST_F(OpenCvSourceTest, WhatIsNotThereCannotBeOpened) {
  OpenCvSourceOptions options;
  for (const auto& [kind, what] : {std::pair{Kind::kFile, std::string(folder_ / "none.mp4")},
                                   {Kind::kV4l2, std::string("/dev/video_that_is_not")},
                                   {Kind::kGStreamer, std::string("nosuchelement")}}) {
    options.kind = kind, options.what = what;
    EXPECT_FALSE(OpenCvSource(options)()->Open()) << what;
  }
}

TEST_F(OpenCvSourceTest, APipelineOfGStreamerIsACamera) {
  OpenCvSourceOptions options;
  options.kind = Kind::kGStreamer;
  options.what = "videotestsrc is-live=true ! video/x-raw,format=BGR,width=64,height=48,framerate=100/1";
  options.size = {64, 48};
  LiveCamera camera(OpenCvSource(options), {});
  for (int i = 0; i < 3; ++i) {
    const auto frame = camera.Next(10);
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->image.size(), options.size);
  }
}

}  // namespace
}  // namespace kestrel::vision
