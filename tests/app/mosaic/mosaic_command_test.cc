// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <vector>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"
#include "vision/enhance/canvas/geotiff.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A camera of 320 x 240 pixels that looks down from 20 m on ground of random blotches, and moves by 1 m, which is 20
// pixels, to the east from image to image.
class MosaicCommandTest : public InTemporaryFolder {
 protected:
  static constexpr int kStep_px = 20;

  void SetUp() override {
    InTemporaryFolder::SetUp();
    cv::Mat fine(300, 700, CV_32FC3);
    cv::RNG(3).fill(fine, cv::RNG::NORMAL, 0, 90);
    cv::GaussianBlur(fine, fine, {}, 2);
    fine.convertTo(ground_, CV_8U, 3, 128);
    std::ofstream(File("camera.yaml"))
        << "model: pinhole\nwidth_px: 320\nheight_px: 240\nfx_px: 400\nfy_px: 400\n"
           "cx_px: 159.5\ncy_px: 119.5\n";
    arguments_.out = File("mosaic.png");
    arguments_.csv = File("places.csv");
    arguments_.compose = "feather";
    arguments_.quiet = true;
    WriteImages(8);
  }
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  cv::Mat Image(int i) const { return ground_(cv::Rect(kStep_px * i, 30, 320, 240)); }
  void WriteImages(int images) {
    arguments_.input = File(fmt::format("images_{}", images));
    std::filesystem::create_directory(arguments_.input);
    for (int i = 0; i < images; ++i) cv::imwrite(fmt::format("{}/{:03}.png", arguments_.input, i), Image(i));
  }
  void WritePoses(int images) {
    arguments_.poses = File("poses.csv");
    arguments_.camera = File("camera.yaml");
    std::ofstream csv(arguments_.poses);
    csv << "north_m,east_m,down_m,yaw_deg,pitch_deg,roll_deg\n";
    for (int i = 0; i < images; ++i) csv << "100," << 50 + i << ",-20,0,0,0\n";
  }
  // The rows below the header, cell by cell.
  std::vector<std::vector<std::string>> Rows() const {
    std::vector<std::vector<std::string>> rows;
    std::ifstream csv(arguments_.csv);
    for (std::string line; std::getline(csv, line);) {
      std::vector<std::string>& row = rows.emplace_back();
      std::istringstream cells(line + ',');
      for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    }
    for (const auto& row : rows) EXPECT_EQ(row.size(), 16u);
    if (!rows.empty()) rows.erase(rows.begin());
    return rows;
  }
  std::string Refusal() const {
    try {
      MosaicCommand(arguments_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }

  cv::Mat ground_;
  MosaicArguments arguments_;
};

TEST_F(MosaicCommandTest, ImagesBecomeTheGroundThatTheyShow) {
  ASSERT_TRUE(MosaicCommand(arguments_));
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 8u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i][3], i == 0 ? "first" : "followed");
    EXPECT_NEAR(std::stod(rows[i][11]) - std::stod(rows[0][11]), kStep_px * static_cast<double>(i), 0.3) << i;
    EXPECT_NEAR(std::stod(rows[i][12]), std::stod(rows[0][12]), 0.3) << i;
    EXPECT_EQ(rows[i][13], "") << "nothing says where the ground is";
  }
  const cv::Mat mosaic = cv::imread(arguments_.out);
  ASSERT_NEAR(mosaic.cols, 320 + 7 * kStep_px, 4);
  ASSERT_NEAR(mosaic.rows, 240, 4);
  cv::Mat correlation;
  cv::matchTemplate(mosaic, ground_(cv::Rect(40, 60, 380, 180)), correlation, cv::TM_CCOEFF_NORMED);
  double most = 0;
  cv::minMaxLoc(correlation, nullptr, &most);
  EXPECT_GT(most, 0.95);
}

TEST_F(MosaicCommandTest, PosesSayWhereTheGroundIs) {
  if (!vision::GeoTiffIsAvailable()) GTEST_SKIP() << "this build has no GeoTIFF";
  WritePoses(8);
  arguments_.geotiff = File("ground.tif");
  arguments_.pose_sigma_m = 0.1;
  ASSERT_TRUE(MosaicCommand(arguments_));
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 8u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(std::stod(rows[i][13]), 100, 0.1) << i;
    EXPECT_NEAR(std::stod(rows[i][14]), 50 + static_cast<double>(i), 0.1) << i;
  }
  EXPECT_FALSE(cv::imread(arguments_.geotiff).empty());
}

TEST_F(MosaicCommandTest, ImagesBeyondTheTableOfPosesAreFollowedWithoutOne) {
  WritePoses(3);
  ASSERT_TRUE(MosaicCommand(arguments_));
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 8u);
  EXPECT_EQ(rows[7][3], "followed");
  EXPECT_NEAR(std::stod(rows[7][14]), 57, 0.5);
}

TEST_F(MosaicCommandTest, PosesOfAnotherLengthAreTold) {
  arguments_.quiet = false;
  const auto told = [&](int poses) {
    WritePoses(poses);
    ::testing::internal::CaptureStdout();
    EXPECT_TRUE(MosaicCommand(arguments_));
    return ::testing::internal::GetCapturedStdout();
  };
  EXPECT_THAT(told(3), AllOf(HasSubstr("without a pose in"), HasSubstr(": 5 images\n")));
  EXPECT_THAT(told(10), AllOf(HasSubstr("left over in"), HasSubstr(": 2 poses;")));
  EXPECT_THAT(told(8), AllOf(HasSubstr("8 images, 8 in a mosaic"), Not(HasSubstr(" pose"))));
}

TEST_F(MosaicCommandTest, AFileThatWasAskedForAndCannotBeIsNotMet) {
  if (!vision::GeoTiffIsAvailable()) GTEST_SKIP() << "this build has no GeoTIFF";
  WritePoses(8);
  arguments_.geotiff = File("ground.tif");
  const auto with_poses = [&](const std::string& rows) {
    std::ofstream(arguments_.poses) << "north_m,east_m,down_m,yaw_deg,pitch_deg,roll_deg\n" << rows;
    return MosaicCommand(arguments_);
  };
  EXPECT_TRUE(with_poses(",,,,,\n100,51,-20,0,0,0\n")) << "the second image lays it out";
  EXPECT_TRUE(std::filesystem::exists(arguments_.geotiff));
  EXPECT_NEAR(std::stod(Rows()[0][14]), 50, 0.1);
  std::filesystem::remove(arguments_.geotiff);
  cv::imwrite(arguments_.input + "/001.png", cv::Mat(240, 320, CV_8UC3, cv::Scalar(90, 90, 90)));
  EXPECT_FALSE(with_poses(",,,,,\n100,51,-20,0,0,0\n")) << "the only image with a pose is in no mosaic";
  EXPECT_FALSE(std::filesystem::exists(arguments_.geotiff));
}

TEST_F(MosaicCommandTest, PosesThatCannotBeAreRefusedWithTheirPlace) {
  WritePoses(8);
  const auto refused = [&](const std::string& rows) {
    std::ofstream(arguments_.poses) << "north_m,east_m,down_m,yaw_deg,pitch_deg,roll_deg\n" << rows;
    return Refusal();
  };
  EXPECT_THAT(refused("1,2,-20,0,0,0\n1,1e9,-20,0,0,0\n"),
              AllOf(HasSubstr("poses.csv:3"), HasSubstr("east_m")));
  EXPECT_THAT(refused("1,2,-20,0,4000,0\n"), AllOf(HasSubstr("poses.csv:2"), HasSubstr("pitch_deg")));
  EXPECT_THAT(refused("1,2,20,0,0,0\n"), HasSubstr("--ground-down-m"));
}

TEST_F(MosaicCommandTest, AnImageThatCannotBeReadIsNamedAndTheRestGoesOn) {
  std::ofstream(arguments_.input + "/000.png");
  std::ofstream(arguments_.input + "/004.png") << "no image";
  const std::string whole = arguments_.input + "/006.png";
  std::filesystem::resize_file(whole, std::filesystem::file_size(whole) / 3);
  arguments_.video = File("growing.mp4");
  ASSERT_TRUE(MosaicCommand(arguments_));
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 8u);
  for (const std::size_t i : {0u, 4u, 6u}) EXPECT_EQ(rows[i][3], "unreadable") << i;
  EXPECT_EQ(rows[7][3], "followed");
  EXPECT_TRUE(std::filesystem::exists(arguments_.video));
}

TEST_F(MosaicCommandTest, OneImageIsAMosaicOfItself) {
  WriteImages(1);
  EXPECT_FALSE(MosaicCommand(arguments_)) << "nothing was joined";
  ASSERT_EQ(Rows().size(), 1u);
  EXPECT_EQ(Rows()[0][3], "first");
  const cv::Mat mosaic = cv::imread(arguments_.out);
  EXPECT_EQ(mosaic.size(), cv::Size(320, 240));
}

TEST_F(MosaicCommandTest, ImagesOfWhichNoTwoAgreeAreNotMet) {
  for (int i = 0; i < 8; ++i) {
    cv::Mat noise(240, 320, CV_8UC3);
    cv::RNG(static_cast<std::uint64_t>(50 + i)).fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::imwrite(fmt::format("{}/{:03}.png", arguments_.input, i), noise);
  }
  EXPECT_FALSE(MosaicCommand(arguments_));
}

// A name at which nothing can be kept, as on a full disk.
TEST_F(MosaicCommandTest, OfAVideoThatCannotBeWrittenNothingIsLeft) {
  arguments_.video = File("growing.mp4");
  std::filesystem::create_symlink("/dev/full", arguments_.video + ".part");
  EXPECT_THROW(MosaicCommand(arguments_), std::runtime_error);
  EXPECT_FALSE(std::filesystem::is_symlink(arguments_.video + ".part"));
  EXPECT_FALSE(std::filesystem::exists(arguments_.video));
  EXPECT_TRUE(std::filesystem::exists(arguments_.out)) << "the mosaic is written";
}

TEST_F(MosaicCommandTest, OptionsOfPosesAndOfTheVideoNeedThem) {
  const auto refusal = [](std::vector<std::string> words) -> std::string {
    CLI::App app;
    MosaicArguments arguments;
    AddMosaicCommand(app, arguments);
    words.insert(words.begin(), {"mosaic", "x.mp4", "--out", "x.png"});
    std::reverse(words.begin(), words.end());
    try {
      app.parse(words);
    } catch (const CLI::ParseError& e) {
      return e.what();
    }
    return "accepted";
  };
  for (const char* option : {"--ground-down-m", "--pose-sigma-m", "--pose-sigma-deg", "--mount-pitch-deg"})
    EXPECT_THAT(refusal({option, "1"}), AllOf(HasSubstr(option), HasSubstr("--poses"))) << option;
  EXPECT_THAT(refusal({"--blend", "nearest"}), HasSubstr("--video"));
  EXPECT_THAT(refusal({"--camera-name", "cam1"}), HasSubstr("--camera"));
  EXPECT_EQ(refusal({"--poses", "p.csv", "--ground-down-m", "1"}), "accepted");
}

TEST_F(MosaicCommandTest, AnImageOfAnotherSizeAndOneWithoutTextureAreNamedAndLeftOut) {
  cv::imwrite(arguments_.input + "/003.png", cv::Mat(240, 320, CV_8UC3, cv::Scalar(90, 90, 90)));
  cv::imwrite(arguments_.input + "/005.png", ground_(cv::Rect(0, 0, 160, 120)));
  ASSERT_TRUE(MosaicCommand(arguments_));
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 8u);
  EXPECT_EQ(rows[3][3], "no_texture");
  EXPECT_EQ(rows[5][3], "other_size");
  EXPECT_EQ(rows[5][11], "");
  EXPECT_NEAR(std::stod(rows[7][11]) - std::stod(rows[0][11]), 7 * kStep_px, 0.5);
}

TEST_F(MosaicCommandTest, ImagesWithoutTextureMakeNoMosaic) {
  for (int i = 0; i < 8; ++i)
    cv::imwrite(fmt::format("{}/{:03}.png", arguments_.input, i),
                cv::Mat(240, 320, CV_8UC3, cv::Scalar(90, 90, 90)));
  EXPECT_FALSE(MosaicCommand(arguments_));
  EXPECT_FALSE(std::filesystem::exists(arguments_.out));
}

TEST_F(MosaicCommandTest, EveryMistakeIsToldAtOnce) {
  arguments_.input = File("none.mp4");
  arguments_.out = File("mosaic.gif");
  arguments_.video = File("growing.avi");
  arguments_.geotiff = File("ground.png");
  arguments_.surface = "sphere";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("none.mp4"), HasSubstr(".png or .jpg"), HasSubstr(".mp4"),
                               HasSubstr(".tif"), HasSubstr("with --poses")));
}

TEST_F(MosaicCommandTest, WhatIsNoVideoIsRefused) {
  std::ofstream(File("text.mp4")) << "no video";
  arguments_.input = File("text.mp4");
  EXPECT_THAT(Refusal(), HasSubstr("text.mp4"));
  std::filesystem::create_directory(File("empty"));
  arguments_.input = File("empty");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("empty"), HasSubstr("folder of images")));
}

TEST_F(MosaicCommandTest, ASphereAndPosesNeedTheCamera) {
  arguments_.surface = "sphere";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--surface"), HasSubstr("--fov-deg")));
  arguments_.surface = "plane";
  WritePoses(8);
  arguments_.camera.clear();
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--poses"), HasSubstr("--camera")));
}

TEST_F(MosaicCommandTest, PosesWithoutTheirColumnsAreRefused) {
  WritePoses(8);
  std::ofstream(arguments_.poses) << "north_m,east_m\n1,2\n";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("poses.csv:1"), HasSubstr("down_m"), HasSubstr("no such column")));
}

TEST_F(MosaicCommandTest, NoFileIsWrittenTwiceNorOverOneThatIsRead) {
  arguments_.video = arguments_.csv = File("both.mp4");
  EXPECT_THAT(Refusal(), HasSubstr("is that of --csv too"));
  arguments_.video.clear();
  WritePoses(8);
  arguments_.csv = arguments_.poses;
  EXPECT_THAT(Refusal(), HasSubstr("is read"));
}

TEST_F(MosaicCommandTest, InterlacedVideoIsToldWithItsRemedy) {
  arguments_.quiet = false;
  const auto printed = [&] {
    testing::internal::CaptureStdout();
    MosaicCommand(arguments_);
    std::fflush(stdout);
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_THAT(printed(), Not(HasSubstr("interlaced")));
  for (int i = 0; i < 8; ++i) {
    cv::Mat image = Image(i).clone();
    const cv::Mat later = ground_(cv::Rect(kStep_px * i + kStep_px / 2, 30, 320, 240));
    for (int r = 1; r < image.rows; r += 2) later.row(r).copyTo(image.row(r));
    cv::imwrite(fmt::format("{}/{:03}.png", arguments_.input, i), image);
  }
  EXPECT_THAT(printed(),
              AllOf(HasSubstr("interlaced: 8 of 8"), HasSubstr("--deinterlace"), HasSubstr("yadif")));
  arguments_.deinterlace = true;
  EXPECT_THAT(printed(), Not(HasSubstr("interlaced")));
}

}  // namespace
}  // namespace kestrel::app
