// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/horizon_command.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class HorizonCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::ofstream(File("camera.yaml")) << "model: pinhole\nwidth_px: 320\nheight_px: 240\nfx_px: 160\n"
                                          "fy_px: 160\ncx_px: 159.5\ncy_px: 119.5\n";
    // Level: sky above the middle, ground below it.
    cv::Mat image(240, 320, CV_8UC3, cv::Scalar(235, 200, 170));
    image.rowRange(120, 240).setTo(cv::Scalar(60, 95, 80));
    cv::Mat noise(image.size(), CV_8UC3);
    cv::RNG(7).fill(noise, cv::RNG::NORMAL, 10, 3);
    cv::add(image, noise, image);
    cv::imwrite(File("image.png"), image);
    arguments_.input = File("image.png");
    arguments_.camera = File("camera.yaml");
    arguments_.mount.pitch_deg = 90;
    arguments_.csv = File("out.csv");
    arguments_.quiet = true;
  }
  std::string File(const char* name) const { return (folder_ / name).string(); }
  std::string Row() const {
    std::ifstream csv(arguments_.csv);
    std::string header, row;
    std::getline(csv, header), std::getline(csv, row);
    return row;
  }
  std::string Refusal() const {
    try {
      HorizonCommand(arguments_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }
  HorizonArguments arguments_;
};

TEST_F(HorizonCommandTest, ALevelPhotographIsLevel) {
  arguments_.out = File("seen.png");
  HorizonCommand(arguments_);
  double roll = 90, pitch = 90;
  ASSERT_EQ(std::sscanf(Row().c_str(), "0,0.000000000,%lf,%lf", &roll, &pitch), 2) << Row();
  EXPECT_NEAR(roll, 0, 0.2);
  EXPECT_NEAR(pitch, 0, 0.4);  // the horizon lies half a pixel, 0.18 degrees, from the middle row
  const cv::Mat seen = cv::imread(arguments_.out);
  EXPECT_EQ(seen.cols, 320);
  EXPECT_GT(seen.rows, 240);  // what is said of it stands below
}

TEST_F(HorizonCommandTest, ABlackPictureHasAReasonAndNoAttitude) {
  cv::imwrite(File("image.png"), cv::Mat::zeros(240, 320, CV_8UC3));
  HorizonCommand(arguments_);
  EXPECT_THAT(Row(), HasSubstr("dark"));
}

TEST_F(HorizonCommandTest, APhotographFromACameraSaidToLookDownIsAnsweredWithTheOptionForOneThatLooksAhead) {
  arguments_.quiet = false;
  const auto printed = [&] {
    testing::internal::CaptureStdout();
    HorizonCommand(arguments_);
    std::fflush(stdout);
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_THAT(printed(), AllOf(HasSubstr("roll"), Not(HasSubstr("--mount-pitch-deg"))));
  arguments_.mount.pitch_deg = 0, arguments_.mount_given = true;
  EXPECT_THAT(printed(), AllOf(HasSubstr("no attitude"), HasSubstr("--mount-pitch-deg 90")));
}

TEST_F(HorizonCommandTest, APhotographOfWhichNoMountIsGivenIsTakenToLookAheadAndThatIsSaid) {
  arguments_.quiet = false;
  arguments_.mount.pitch_deg = 0;
  testing::internal::CaptureStdout();
  HorizonCommand(arguments_);
  std::fflush(stdout);
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              AllOf(HasSubstr("look ahead"), HasSubstr("--mount-pitch-deg"), HasSubstr("roll")));
  double roll = 90, pitch = 90;
  ASSERT_EQ(std::sscanf(Row().c_str(), "0,0.000000000,%lf,%lf", &roll, &pitch), 2) << Row();
  EXPECT_NEAR(roll, 0, 0.2);
  EXPECT_NEAR(pitch, 0, 0.4);
}

TEST_F(HorizonCommandTest, EveryMistakeIsToldAtOnce) {
  arguments_.input = File("none.png");
  arguments_.camera = File("none.yaml");
  arguments_.mask = File("mask.png");
  arguments_.out = File("nowhere/seen.gif");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("none.png"), HasSubstr("none.yaml"), HasSubstr("--mask"),
                               HasSubstr(".png or .jpg"), HasSubstr("nowhere")));
}

TEST_F(HorizonCommandTest, TheInputIsNotOverwritten) {
  arguments_.out = arguments_.input;
  EXPECT_THAT(Refusal(), HasSubstr("is read; valid: another file"));
}

TEST_F(HorizonCommandTest, ACameraOfAnotherSizeIsRefused) {
  cv::imwrite(File("image.png"), cv::Mat::zeros(100, 100, CV_8UC3));
  EXPECT_THAT(Refusal(), HasSubstr("100"));
}

}  // namespace
}  // namespace kestrel::app
