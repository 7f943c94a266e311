// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/track_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <vector>

#include "base/diagnostics.h"
#include "records/video/video.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kFocal_px = 400;

// A camera of 320 x 240 pixels that looks down on a picture of 0.4 m by 0.5 m from 1 m; the picture is of blocks at
// random.
class TrackCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::ofstream(File("camera.yaml"))
        << "model: pinhole\nwidth_px: 320\nheight_px: 240\nfx_px: 400\nfy_px: 400\n"
           "cx_px: 159.5\ncy_px: 119.5\n";
    cv::Mat blocks(16, 20, CV_8UC1);
    cv::RNG(4).fill(blocks, cv::RNG::UNIFORM, 0, 256);
    cv::resize(blocks, picture_, {500, 400}, 0, 0, cv::INTER_NEAREST);
    cv::imwrite(File("picture.png"), picture_);
    cv::imwrite(File("image.png"), ImageOf(picture_, {159.5F, 119.5F}));
    arguments_.input = File("image.png");
    arguments_.camera = File("camera.yaml");
    arguments_.landmark = File("picture.png");
    arguments_.size_m = {0.4, 0.5};
    arguments_.csv = File("out.csv");
    arguments_.quiet = true;
  }
  std::string File(const char* name) const { return (folder_ / name).string(); }

  // From 1 m, with its middle there.
  static cv::Mat ImageOf(const cv::Mat& picture, const cv::Point2f& middle) {
    cv::Mat image(240, 320, CV_8UC3, cv::Scalar(120, 120, 120)), small, colour;
    cv::resize(picture, small, {static_cast<int>(0.5 * kFocal_px), static_cast<int>(0.4 * kFocal_px)}, 0, 0,
               cv::INTER_AREA);
    cv::cvtColor(small, colour, cv::COLOR_GRAY2BGR);
    const cv::Matx23f place(1, 0, middle.x - (static_cast<float>(small.cols) - 1) / 2, 0, 1,
                            middle.y - (static_cast<float>(small.rows) - 1) / 2);
    cv::warpAffine(colour, image, place, image.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
    return image;
  }
  void WriteVideo(const char* name, int frames, const cv::Size& size = {320, 240}) const {
    records::Video video(File(name), 10);
    for (int i = 0; i < frames; ++i) {
      cv::Mat image;
      cv::resize(ImageOf(picture_, {150.0F + 3 * static_cast<float>(i), 119.5F}), image, size);
      video.Write(image);
    }
    video.Close();
  }
  // The rows below the header, cell by cell.
  std::vector<std::vector<std::string>> Rows() const {
    std::vector<std::vector<std::string>> rows;
    std::ifstream csv(arguments_.csv);
    for (std::string line; std::getline(csv, line);) {
      std::vector<std::string>& row = rows.emplace_back();
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    }
    for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size());
    if (!rows.empty()) rows.erase(rows.begin());
    return rows;
  }
  std::string Refusal() const {
    try {
      TrackCommand(arguments_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }

  cv::Mat picture_;
  TrackArguments arguments_;
};

TEST_F(TrackCommandTest, APictureIsFoundWhereItLies) {
  arguments_.out = File("seen.png");
  TrackCommand(arguments_);
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0][2], "found");
  EXPECT_NEAR(std::stod(rows[0][3]), 0, 0.002);
  EXPECT_NEAR(std::stod(rows[0][4]), 0, 0.002);
  EXPECT_NEAR(std::stod(rows[0][5]), 1, 0.004);
  EXPECT_NEAR(std::stod(rows[0][6]), -90, 0.3);  // x of T points up in the image, which is -y of C
  const cv::Mat seen = cv::imread(arguments_.out);
  EXPECT_EQ(seen.cols, 320);
  EXPECT_GT(seen.rows, 240);  // what is said of it stands below
}

TEST_F(TrackCommandTest, AHeightAloneHasTheWidthOfThePicture) {
  arguments_.size_m = {0.4};
  TrackCommand(arguments_);
  EXPECT_NEAR(std::stod(Rows()[0][5]), 1, 0.004);
}

TEST_F(TrackCommandTest, AVideoIsFollowedAndDrawn) {
  WriteVideo("flight.mp4", 5);
  arguments_.input = File("flight.mp4");
  arguments_.out = File("seen.mp4");
  TrackCommand(arguments_);
  const auto rows = Rows();
  ASSERT_EQ(rows.size(), 5u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i][2], i == 0 ? "found" : "tracked");
    EXPECT_NEAR(std::stod(rows[i][3]), (150 + 3 * static_cast<double>(i) - 159.5) / kFocal_px, 0.003) << i;
  }
  EXPECT_GT(std::filesystem::file_size(arguments_.out), 1000u);
}

TEST_F(TrackCommandTest, CornersByHandBeginWhereNothingElseFindsIt) {
  // Nothing but the inside of the picture is in the image.
  const cv::Mat inside = picture_(cv::Rect(100, 100, 300, 200));
  cv::Mat image;
  cv::resize(inside, image, {320, 213}, 0, 0, cv::INTER_AREA);
  cv::copyMakeBorder(image, image, 0, 27, 0, 0, cv::BORDER_REFLECT);
  cv::imwrite(File("image.png"), image);
  // The corners of another rectangle than the landmark's: of its middle, for a landmark that is the middle.
  cv::imwrite(File("picture.png"), inside);
  arguments_.size_m = {0.2, 0.3};
  arguments_.corners = {"0,0", "319,1", "318,212", "1,211"};
  TrackCommand(arguments_);
  ASSERT_NE(Rows()[0][2], "lost");
  EXPECT_NEAR(std::stod(Rows()[0][5]), kFocal_px * 0.3 / 320, 0.01);
}

TEST_F(TrackCommandTest, CornersThatAreNoneAreRefusedWithTheRemedy) {
  const auto refusal = [&](std::vector<std::string> corners) {
    arguments_.corners = std::move(corners);
    return Refusal();
  };
  EXPECT_THAT(refusal({"10,10", "200,10", "10,200", "200,200"}),
              AllOf(HasSubstr("cross"), HasSubstr("top left")));
  EXPECT_THAT(refusal({"10,10", "100,10", "200,10", "100,200"}), HasSubstr("on a line"));
  EXPECT_THAT(refusal({"10,10", "10,200", "200,200", "200,10"}), HasSubstr("mirror"));
  EXPECT_THAT(refusal({"10,10", "400,10", "200,200", "10,200"}), HasSubstr("outside the image"));
  EXPECT_THAT(refusal({"10;10", "200,10", "200,200", "10,200"}), HasSubstr("is no pixel"));
}

TEST_F(TrackCommandTest, EveryMistakeIsToldAtOnce) {
  arguments_.input = File("none.png");
  arguments_.landmark = "helpad";
  arguments_.out = File("nowhere/seen.gif");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("none.png"), HasSubstr("'helipad'"), HasSubstr("--size-m"),
                               HasSubstr(".png or .jpg"), HasSubstr("nowhere")));
}

TEST_F(TrackCommandTest, APictureOfOneColourOrWithoutASizeIsRefused) {
  arguments_.size_m.clear();
  EXPECT_THAT(Refusal(), HasSubstr("does not tell how large it is"));
  arguments_.size_m = {0.4, 0.5};
  cv::imwrite(File("picture.png"), cv::Mat(100, 100, CV_8UC1, cv::Scalar(90)));
  EXPECT_THAT(Refusal(), HasSubstr("of one colour"));
}

TEST_F(TrackCommandTest, ACameraOfAnotherSizeIsRefused) {
  cv::imwrite(File("image.png"), cv::Mat::zeros(100, 100, CV_8UC3));
  EXPECT_THAT(Refusal(), HasSubstr("100"));
}

TEST_F(TrackCommandTest, AVideoThatChangesItsSizeIsRefused) {
  WriteVideo("one.mp4", 3);
  WriteVideo("two.mp4", 3, {640, 480});
  // One after the other, as a camera that was set anew while it recorded.
  std::ofstream(File("list.txt")) << "file one.ts\nfile two.ts\n";
  const std::string in = "cd " + folder_.string() + " && ";
  const std::string quiet = "ffmpeg -nostdin -loglevel error ";
  ASSERT_EQ(std::system((in + quiet + "-i one.mp4 -c copy one.ts && " + quiet +
                         "-i two.mp4 -c copy two.ts && " + "cat one.ts two.ts > both.ts")
                            .c_str()),
            0);
  arguments_.input = File("both.ts");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("from 320 x 240 to 640 x 480"), HasSubstr("ffmpeg -ss")));
}

TEST_F(TrackCommandTest, AVideoThatBreaksOffLeavesWhatWasTracked) {
  WriteVideo("whole.mp4", 12);
  ASSERT_EQ(std::system(("cd " + folder_.string() +
                         " && ffmpeg -nostdin -loglevel error -i whole.mp4 -c:v mjpeg -q:v 3 whole.avi")
                            .c_str()),
            0);
  std::ifstream whole(File("whole.avi"), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(whole)), {});
  std::ofstream(File("part.avi"), std::ios::binary) << bytes.substr(0, bytes.size() * 6 / 10);
  arguments_.input = File("part.avi");
  try {
    TrackCommand(arguments_);
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("broke off"));
  }
  EXPECT_GE(Rows().size(), 3u);
  EXPECT_LT(Rows().size(), 12u);
}

TEST_F(TrackCommandTest, ABallIsMeasuredByItsColourAndDiameter) {
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(150, 140, 130));
  constexpr double kDistance_m = 4, kDiameter_m = 0.5;
  const double radius_px = kFocal_px * std::tan(std::asin(kDiameter_m / 2 / kDistance_m));
  cv::circle(image, cv::Point2d(16 * 159.5, 16 * 119.5), static_cast<int>(16 * radius_px), {30, 30, 210},
             cv::FILLED, cv::LINE_AA, 4);
  cv::imwrite(File("image.png"), image);
  arguments_.landmark.clear();
  arguments_.size_m.clear();
  arguments_.ball = {"hue=0", "diameter_m=0.5"};
  arguments_.out = File("seen.png");
  TrackCommand(arguments_);
  EXPECT_EQ(Rows()[0][2], "tracked");
  EXPECT_NEAR(std::stod(Rows()[0][5]), kDistance_m, 0.1);
}

TEST_F(TrackCommandTest, ABallsWordsAreChecked) {
  EXPECT_THAT((arguments_.ball = {"hue=0"}, Refusal()),
              AllOf(HasSubstr("no diameter_m"), HasSubstr("one of them")));
  arguments_.landmark.clear();
  arguments_.size_m.clear();
  EXPECT_THAT((arguments_.ball = {"hue=0", "diametr_m=1", "diameter_m=1"}, Refusal()),
              HasSubstr("'diameter_m'"));
  EXPECT_THAT((arguments_.ball = {"hue=0", "diameter_m=100"}, Refusal()), HasSubstr("20"));
}

}  // namespace
}  // namespace kestrel::app
