// SPDX-License-Identifier: Apache-2.0
#include "app/stabilise/stabilise_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <ios>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A folder of images of a camera that shakes before a picture of random blotches.
class StabiliseCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    cv::Mat fine(200, 260, CV_32FC3), scene;
    cv::RNG(3).fill(fine, cv::RNG::NORMAL, 0, 90);
    cv::GaussianBlur(fine, fine, {}, 2);
    fine.convertTo(scene, CV_8U, 3, 128);
    arguments_.input = File("images");
    std::filesystem::create_directory(arguments_.input);
    for (int i = 0; i < 12; ++i)
      cv::imwrite(Image(i),
                  scene(cv::Rect(40 + static_cast<int>(std::lround(10 * std::sin(i))), 30, 160, 120)));
    std::ofstream(File("camera.yaml"))
        << "model: pinhole\nwidth_px: 160\nheight_px: 120\nfx_px: 150\nfy_px: 150\n"
           "cx_px: 79.5\ncy_px: 59.5\n";
    arguments_.csv = File("path.csv");
    arguments_.options.mode = "reference";
    arguments_.quiet = true;
  }
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  std::string Image(int i) const { return fmt::format("{}/{:03}.png", arguments_.input, i); }
  std::vector<std::string> Rows() const {
    std::vector<std::string> rows;
    std::ifstream csv(arguments_.csv);
    for (std::string line; std::getline(csv, line);) rows.push_back(line);
    return rows;
  }
  std::string Refusal() const {
    try {
      StabiliseCommand(arguments_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }
  StabiliseArguments arguments_;
};

TEST_F(StabiliseCommandTest, EachModeWritesARowAndAnImageForEachImage) {
  int modes = 0;
  for (const char* mode : {"reference", "smooth", "offline"}) {
    arguments_.options.mode = mode;
    arguments_.out = File(fmt::format("{}.mp4", mode));
    arguments_.before_after = File(fmt::format("{}_both.mp4", mode));
    StabiliseCommand(arguments_);
    const auto rows = Rows();
    ASSERT_EQ(rows.size(), 13u) << mode;
    for (const std::string& row : rows)
      EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(rows[0].begin(), rows[0].end(), ','))
          << row;
    EXPECT_THAT(rows[1], HasSubstr(",first,"));
    EXPECT_THAT(rows[12], HasSubstr(",followed,"));
    EXPECT_GT(std::filesystem::file_size(arguments_.out), 1000u);
    EXPECT_GT(std::filesystem::file_size(arguments_.before_after), 1000u);
    ++modes;
  }
  EXPECT_EQ(modes, 3);
}

TEST_F(StabiliseCommandTest, WhatIsNoVideoIsRefused) {
  const std::string folder = arguments_.input;
  arguments_.input = Image(0);
  EXPECT_THAT(Refusal(), HasSubstr("one image, which has no motion"));
  arguments_.input = File("nowhere.mp4");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("cannot be read"), Not(HasSubstr("one image"))));
  arguments_.input = File("camera.yaml");
  EXPECT_THAT(Refusal(), HasSubstr("neither an image nor a video"));
  arguments_.input = folder, arguments_.csv = "";
  EXPECT_THAT(Refusal(), HasSubstr("there would be no result"));
}

TEST_F(StabiliseCommandTest, AGyroNeedsItsFileAndACamera) {
  arguments_.options.by = "gyro";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--camera: not given"), HasSubstr("--imu: not given")));
  arguments_.options.by = "vision", arguments_.imu = File("gyro.csv");
  EXPECT_THAT(Refusal(), HasSubstr("of no use to --by vision"));
}

TEST_F(StabiliseCommandTest, AGyroOfAnotherTimeIsToldUnlessItsOffsetIsGiven) {
  arguments_.options.by = "gyro", arguments_.camera = File("camera.yaml"), arguments_.imu = File("gyro.csv");
  std::ofstream csv(arguments_.imu);
  csv << std::fixed << "t_s,wx_rad_s,wy_rad_s,wz_rad_s\n";
  for (int i = 0; i < 400; ++i) csv << 1000 + i / 200.0 << ",0,0.1,0\n";
  csv.close();
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--imu"), HasSubstr("at no offset of up to 2 s")));
  arguments_.imu_offset_s = 1000;
  StabiliseCommand(arguments_);
  ASSERT_EQ(Rows().size(), 13u);
  EXPECT_THAT(Rows()[5], HasSubstr(",gyro,"));
}

TEST_F(StabiliseCommandTest, AnImageOfAnotherSizeEndsAVideoAndStartsTheViewAnewWithoutOne) {
  cv::imwrite(Image(12), cv::Mat(60, 80, CV_8UC3, cv::Scalar(9, 99, 199)));
  StabiliseCommand(arguments_);
  ASSERT_EQ(Rows().size(), 14u);
  EXPECT_THAT(Rows()[13], HasSubstr(",resized,"));
  arguments_.out = File("steady.mp4");
  try {
    StabiliseCommand(arguments_);
    FAIL() << "accepted";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("it broke off after 12 images"), HasSubstr("80 x 60")));
  }
  EXPECT_EQ(Rows().size(), 14u);
  EXPECT_THAT(Rows()[13], HasSubstr(",resized,"));
}

TEST_F(StabiliseCommandTest, WhereTheSizeChangesTheImagesInTheLagAreWritten) {
  cv::imwrite(Image(12), cv::Mat(60, 80, CV_8UC3, cv::Scalar(9, 99, 199)));
  arguments_.options.mode = "smooth", arguments_.options.lag_s = 0.2, arguments_.out = File("steady.mp4");
  EXPECT_THROW(StabiliseCommand(arguments_), std::runtime_error);
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 14u);
  EXPECT_THAT(rows[12], HasSubstr(",followed,"));
  EXPECT_THAT(rows[13], HasSubstr(",resized,"));
  EXPECT_EQ(std::count(rows[13].begin(), rows[13].end(), ','),
            std::count(rows[0].begin(), rows[0].end(), ','));
  EXPECT_EQ(cv::VideoCapture(arguments_.out).get(cv::CAP_PROP_FRAME_COUNT), 12);
}

TEST_F(StabiliseCommandTest, ADamagedFileIsAStateOfItsOwnWhereverItIsDamaged) {
  std::ofstream(Image(3), std::ios::trunc).close();
  std::filesystem::resize_file(Image(7), std::filesystem::file_size(Image(7)) / 2);
  for (const char* mode : {"reference", "smooth"}) {
    arguments_.options.mode = mode, arguments_.options.lag_s = 0.2;
    EXPECT_TRUE(StabiliseCommand(arguments_)) << mode;
    const auto rows = Rows();
    ASSERT_EQ(rows.size(), 13u) << mode;
    for (std::size_t i = 0; i < 12; ++i) {
      EXPECT_THAT(rows[i + 1], ::testing::StartsWith(fmt::format("{},{:.9f},", i, i / 25.0))) << mode;
      EXPECT_THAT(rows[i + 1], HasSubstr(i == 3 || i == 7 ? ",unreadable,"
                                         : i == 0         ? ",first,"
                                                          : ",followed,"))
          << mode;
    }
  }
}

TEST_F(StabiliseCommandTest, WhereNoMotionIsMeasuredNothingIsAchieved) {
  EXPECT_TRUE(StabiliseCommand(arguments_));
  arguments_.frames = 1;
  EXPECT_FALSE(StabiliseCommand(arguments_));
  ASSERT_EQ(Rows().size(), 2u);
  arguments_.frames = 0;
  for (int i = 0; i < 12; ++i) cv::imwrite(Image(i), cv::Mat(120, 160, CV_8UC3, cv::Scalar(90, 90, 90)));
  EXPECT_FALSE(StabiliseCommand(arguments_));
}

TEST_F(StabiliseCommandTest, AHorizonThatIsNowhereSeenIsTold) {
  arguments_.camera = File("camera.yaml"), arguments_.options.by = "sphere", arguments_.level = "skyline";
  arguments_.quiet = false;
  testing::internal::CaptureStdout();
  EXPECT_FALSE(StabiliseCommand(arguments_));
  std::fflush(stdout);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("horizon seen in none of the images"));
}

TEST_F(StabiliseCommandTest, ImagesOfAVideoHaveTheTimesThatTheFileGives) {
  // Of 12 images, three come together, then none for a while.
  const std::string video = File("uneven.mkv");
  const std::string command = fmt::format(
      "ffmpeg -nostdin -loglevel error -framerate 30 -i '{}/%03d.png' -vf "
      "\"setpts='(floor(N/3)*0.5+mod(N,3)*0.1)/TB'\" "
      "-fps_mode vfr -c:v ffv1 '{}'",
      arguments_.input, video);
  ASSERT_EQ(std::system(command.c_str()), 0);
  arguments_.input = video, arguments_.quiet = false;
  testing::internal::CaptureStdout();
  StabiliseCommand(arguments_);
  std::fflush(stdout);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("the images come 0.100 to 0.300 s apart"));
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 13u);
  for (std::size_t i = 0; i < 12; ++i) {
    const double t_s = 0.5 * static_cast<double>(i / 3) + 0.1 * static_cast<double>(i % 3);
    EXPECT_THAT(rows[i + 1], ::testing::StartsWith(fmt::format("{},{:.9f},", i, t_s)));
  }
}

TEST(StabiliseOptions, WhatIsOfNoUseIsRefused) {
  const auto refusal = [](const std::string& options) -> std::string {
    CLI::App app;
    StabiliseArguments arguments;
    AddStabiliseCommand(app, arguments);
    try {
      app.parse("stabilise v.mp4 --csv p.csv " + options);
    } catch (const CLI::ParseError& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal("--lag-s 1 --cutoff-hz 0.3 --unbounded"), "accepted");
  EXPECT_EQ(refusal("--by sphere --camera c --level skyline --mount-pitch-deg 80"), "accepted");
  EXPECT_EQ(refusal("--by both --camera c --imu g.csv --imu-offset-s 1"), "accepted");
  for (const auto& [options, named] : {std::pair{"--imu-offset-s 1", "--imu"},
                                       {"--max-offset-s 1", "--imu"},
                                       {"--imu g.csv --imu-offset-s 1 --max-offset-s 1", "--imu-offset-s"},
                                       {"--mount-pitch-deg 80", "--level none"},
                                       {"--mode reference --unbounded", "--mode reference"},
                                       {"--mode reference --cutoff-hz 1", "--mode reference"},
                                       {"--mode offline --lag-s 1", "--mode offline"},
                                       {"--by sphere --model affine", "--by sphere"},
                                       {"--by gyro --points 90", "--by gyro"},
                                       {"--crop nan", "nan"},
                                       {"--imu g.csv --imu-offset-s nan", "nan"},
                                       {"--cutoff-hz nan", "nan"},
                                       {"--readout-s nan", "nan"},
                                       {"--lag-s nan", "nan"}})
    EXPECT_THAT(refusal(options), AllOf(Not("accepted"), HasSubstr(named))) << options;
}

// A camera that looks ahead over flat ground, and rolls: how much is left is known, since the sky is drawn by it.
TEST_F(StabiliseCommandTest, TheHorizonIsLevelledByTheSkyline) {
  constexpr int kImages = 40;
  std::filesystem::remove_all(arguments_.input);
  std::filesystem::create_directory(arguments_.input);
  cv::Mat fine(900, 900, CV_32FC3), ground, sky(900, 900, CV_8UC3, cv::Scalar(235, 200, 170));
  cv::RNG(4).fill(fine, cv::RNG::NORMAL, 0, 30);
  cv::GaussianBlur(fine, fine, {}, 2);
  fine.convertTo(ground, CV_8U, 3, 80);
  ground.rowRange(450, 900).copyTo(sky.rowRange(450, 900));
  const auto roll_deg = [](int i) { return 6 + 5 * std::sin(0.2 * i); };
  for (int i = 0; i < kImages; ++i) {
    cv::Mat seen;  // the sky's middle row is the horizon
    cv::Mat H = cv::getRotationMatrix2D({450, 449.5}, roll_deg(i), 1);
    H.at<double>(0, 2) -= 450 - 159.5, H.at<double>(1, 2) -= 449.5 - 119.5;
    cv::warpAffine(sky, seen, H, {320, 240}, cv::INTER_AREA);
    cv::imwrite(Image(i), seen);
  }
  std::ofstream(File("wide.yaml")) << "model: pinhole\nwidth_px: 320\nheight_px: 240\nfx_px: 160\n"
                                      "fy_px: 160\ncx_px: 159.5\ncy_px: 119.5\n";
  arguments_.camera = File("wide.yaml"), arguments_.options.by = "sphere", arguments_.level = "skyline";
  arguments_.options.mode = "offline", arguments_.unbounded = true;
  StabiliseCommand(arguments_);
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), kImages + 1u);
  double square_in = 0, square = 0;
  for (int i = 0; i < kImages; ++i) {
    double turn_deg = 90;
    int columns = 0;
    std::istringstream row(rows[static_cast<std::size_t>(i) + 1]);
    for (std::string cell; std::getline(row, cell, ','); ++columns)
      if (columns == 9) turn_deg = std::stod(cell);
    // getRotationMatrix2D turns counter-clockwise, turn_deg is clockwise.
    square_in += roll_deg(i) * roll_deg(i) / kImages;
    square += (turn_deg - roll_deg(i)) * (turn_deg - roll_deg(i)) / kImages;
  }
  EXPECT_GT(std::sqrt(square_in), 5);
  EXPECT_LT(std::sqrt(square), 0.3) << rows[10];
}

TEST_F(StabiliseCommandTest, ALevelViewNeedsTheCamerasRotation) {
  arguments_.level = "skyline";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--level"), HasSubstr("--by sphere, gyro or both")));
}

TEST_F(StabiliseCommandTest, InterlacedVideoIsToldWithItsRemedy) {
  for (int i = 0; i < 12; ++i) {
    cv::Mat image = cv::imread(Image(i));
    const cv::Mat later = cv::imread(Image((i + 1) % 12));
    for (int r = 1; r < image.rows; r += 2) later.row(r).copyTo(image.row(r));
    cv::imwrite(Image(i), image);
  }
  arguments_.quiet = false;
  const auto printed = [&] {
    testing::internal::CaptureStdout();
    StabiliseCommand(arguments_);
    std::fflush(stdout);
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_THAT(printed(), AllOf(HasSubstr("interlaced: "), HasSubstr("--deinterlace"), HasSubstr("yadif")));
  EXPECT_THAT(Rows()[3], ::testing::EndsWith(",1,,"));
  arguments_.deinterlace = true;
  EXPECT_THAT(printed(), Not(HasSubstr("interlaced")));
  EXPECT_THAT(Rows()[3], ::testing::EndsWith(",0,,"));
}

}  // namespace
}  // namespace kestrel::app
