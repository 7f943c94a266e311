// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::vision {
namespace {

class PadFileTest : public InTemporaryFolder {
 protected:
  // A pad of a dark square on white.
  PadReference Pad(int square_px, const char* size_m) {
    cv::Mat picture(256, 256, CV_8U, cv::Scalar(255));
    cv::rectangle(picture, cv::Rect(64, 64, square_px, square_px), cv::Scalar(0), cv::FILLED);
    cv::imwrite((folder_ / "pad.png").string(), picture);
    std::ofstream(folder_ / "pad.yaml") << "texture: pad.png\nsize_m: " << size_m << "\n";
    Mistakes mistakes;
    const PadFile pad = LoadPad(folder_ / "pad.yaml", mistakes);
    mistakes.ThrowIfAny();
    return pad.reference;
  }
  PadFile Load(const std::string& text) {
    std::ofstream(folder_ / "pad.yaml") << text;
    Mistakes mistakes;
    const PadFile pad = LoadPad(folder_ / "pad.yaml", mistakes);
    refusals_.clear();
    for (const std::string& each : mistakes.Texts()) refusals_ += each + "\n";
    return pad;
  }
  std::string refusals_;  // of the last Load
};

TEST_F(PadFileTest, ReadAgainItIsWhatTheFilesNowHold) {
  const PadReference first = Pad(100, "[1, 1]"), same = Pad(100, "[1, 1]");
  ASSERT_FALSE(first.levels.empty());
  ASSERT_FALSE(first.levels[0].corners.empty());
  EXPECT_EQ(same.levels[0].corners, first.levels[0].corners);
  EXPECT_NE(Pad(60, "[1, 1]").levels[0].corners, first.levels[0].corners);  // another picture, under its name
  const PadReference larger = Pad(60, "[2, 1]");
  EXPECT_EQ(larger.length_m, 2);
  EXPECT_EQ(Pad(60, "[1, 1]").length_m, 1);
}

TEST_F(PadFileTest, APictureOfAnySizeAndFormatSpansThePad) {
  for (const char* name : {"pad.png", "pad.jpg"}) {
    for (const cv::Size size : {cv::Size(300, 200), cv::Size(256, 256), cv::Size(1001, 777)}) {
      cv::Mat picture(size, CV_8UC3, cv::Scalar(250, 250, 250));
      picture(cv::Rect(0, 0, size.width / 2, size.height / 2)).setTo(cv::Scalar(10, 10, 10));
      cv::imwrite((folder_ / name).string(), picture);
      const PadFile pad = Load(fmt::format("texture: {}\nsize_m: [0.4, 0.6]\n", name));
      ASSERT_TRUE(refusals_.empty()) << refusals_;
      EXPECT_EQ(pad.reference.levels[0].image.size(), size);
      // One corner of light and dark, in the middle of the pad.
      ASSERT_FALSE(pad.reference.levels[0].corners.empty());
      EXPECT_LT(pad.reference.levels[0].corners[0].norm(), 0.6 * 3 / size.width) << name << size;
      EXPECT_EQ(pad.picture.size(), size);
      EXPECT_EQ(pad.picture.channels(), 3);
    }
  }
}

TEST_F(PadFileTest, OneThatIsGreyIsKeptOnce) {
  cv::Mat picture(256, 256, CV_8UC1);
  cv::RNG(1).fill(picture, cv::RNG::UNIFORM, 0, 256);
  cv::imwrite((folder_ / "pad.png").string(), picture);
  const PadFile pad = Load("texture: pad.png\nsize_m: [0.4, 0.6]\n");
  ASSERT_TRUE(refusals_.empty()) << refusals_;
  ASSERT_EQ(pad.picture.type(), CV_8UC1);
  EXPECT_EQ(cv::norm(pad.picture, picture, cv::NORM_INF), 0);
  EXPECT_EQ(pad.picture.data, pad.reference.levels[0].image.data);
}

TEST_F(PadFileTest, TagsAreThePicture) {
  const PadFile pad = Load("size_m: [1, 0.8]\ntags:\n  - {family: DICT_5X5_50, id: 3, side_m: 0.5}\n");
  ASSERT_TRUE(refusals_.empty()) << refusals_;
  EXPECT_EQ(pad.reference.tags.size(), 1u);
  EXPECT_EQ(pad.texture, folder_ / "pad.yaml");
  EXPECT_FALSE(pad.picture.empty());
}

TEST_F(PadFileTest, WhatCannotBeTrackedIsRefusedWithTheRemedy) {
  cv::imwrite((folder_ / "plain.png").string(), cv::Mat(64, 64, CV_8U, cv::Scalar(130)));
  cv::imwrite((folder_ / "small.png").string(), cv::Mat::eye(20, 20, CV_8U) * 255);
  std::ofstream(folder_ / "text.png") << "not a picture";
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"texture: plain.png\n", "of one colour"},
      {"texture: small.png\n", "20 x 20 pixels, too few to tell it by; valid: sides of at least 32"},
      {"texture: text.png\n", "is not an image"},
      {"texture: none.png\n", "none.png"},
      {"{}\n", "names no picture, and there are no tags"},
      {"texture: plain.png\ntags: [{id: 1}]\n", "valid: one of texture and tags"},
      {"tags: [{family: tag36h1l, id: 1}]\n", "did you mean 'tag36h11'?"},
      {"tags: [{family: tag36h11, id: 1, side_m: 3}]\n", "beyond the picture"}};
  for (const auto& [text, what] : cases) {
    Load(text);
    EXPECT_NE(refusals_.find(what), std::string::npos) << text << refusals_;
  }
}

}  // namespace
}  // namespace kestrel::vision
