// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/gstreamer_pipeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

namespace kestrel::vision {
namespace {

using ::testing::HasSubstr;

constexpr char kSink[] = " ! appsink drop=true max-buffers=1 sync=false";

TEST(GStreamerPipeline, ImagesComeAsTheyAre) {
  for (const char* format : {"BGR", "GRAY8"}) {
    GStreamerPipeline pipeline;
    // A width that rows are padded for.
    ASSERT_TRUE(pipeline.Open(std::string("videotestsrc pattern=solid-color foreground-color=0xff102030 ! "
                                          "video/x-raw,width=37,height=5,format=") +
                                  format + kSink,
                              {}))
        << pipeline.Error();
    for (int i = 0; i < 3; ++i) {
      const cv::Mat image = pipeline.Next();
      ASSERT_EQ(image.size(), cv::Size(37, 5));
      if (image.channels() == 3) {
        EXPECT_EQ(cv::norm(image, cv::Mat(image.size(), CV_8UC3, cv::Scalar(0x30, 0x20, 0x10)), cv::NORM_INF),
                  0);
      } else {
        EXPECT_EQ(cv::norm(image, cv::Mat(image.size(), CV_8UC1, image.at<std::uint8_t>(0, 0)), cv::NORM_INF),
                  0);
      }
    }
  }
}

TEST(GStreamerPipeline, OneThatEndsSaysSo) {
  GStreamerPipeline pipeline;
  ASSERT_TRUE(
      pipeline.Open(std::string("videotestsrc num-buffers=2 ! video/x-raw,format=GRAY8") + kSink, {}));
  while (!pipeline.Next().empty()) continue;
  EXPECT_EQ(pipeline.Error(), "the stream has ended");
}

TEST(GStreamerPipeline, WhatCannotBeIsNamed) {
  GStreamerPipeline pipeline;
  EXPECT_FALSE(pipeline.Open(std::string("nosuchelement") + kSink, {}));
  EXPECT_THAT(pipeline.Error(), HasSubstr("nosuchelement"));
  EXPECT_FALSE(pipeline.Open("videotestsrc ! fakesink", {}));
  EXPECT_THAT(pipeline.Error(), HasSubstr("no appsink"));
  EXPECT_FALSE(pipeline.Open("appsink", {}));
  EXPECT_FALSE(pipeline.Open("", {}));
  EXPECT_FALSE(pipeline.Open(std::string("videotestsrc ! video/x-raw,format=I420") + kSink, {}));
  EXPECT_NE(pipeline.Error(), "");
}

// A message for each few samples of sound: as many as a flood of packets brings.
TEST(GStreamerPipeline, WhatElementsSayIsNotKept) {
  constexpr int kMessages = 20000;
  GStreamerPipeline pipeline;
  const std::size_t before = mallinfo2().uordblks;
  ASSERT_TRUE(pipeline.Open(
      std::string("videotestsrc is-live=true ! video/x-raw,format=GRAY8,width=32,height=24,framerate=100/1") +
          kSink + " audiotestsrc samplesperbuffer=4 num-buffers=" + std::to_string(kMessages) +
          " ! audio/x-raw,rate=48000 ! level interval=1 ! fakesink sync=false",
      {}))
      << pipeline.Error();
  for (int i = 0; i < 50; ++i) ASSERT_FALSE(pipeline.Next().empty());
  const double held_mib =
      (static_cast<double>(mallinfo2().uordblks) - static_cast<double>(before)) / (1 << 20);
  RecordProperty("held_mib", std::to_string(held_mib));
  EXPECT_LT(held_mib, 10);  // kept, they are 20 MiB and more
}

}  // namespace
}  // namespace kestrel::vision
