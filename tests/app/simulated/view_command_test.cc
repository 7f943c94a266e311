// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/view_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/diagnostics.h"
#include "geometry/tait_bryan.h"
#include "records/video/video.h"
#include "records/video/video_reader.h"
#include "tests/support/temporary_folder.h"
#include "vision/camera/views.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A folder with a camera, an image and a video of it.
class ViewCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::ofstream(File("camera.yaml")) << "model: kannala_brandt\nwidth_px: 320\nheight_px: 240\n"
                                          "fx_px: 120\nfy_px: 120\ncx_px: 159.5\ncy_px: 119.5\n"
                                          "field_deg: 190\n";
    camera_.width_px = 320, camera_.height_px = 240;
    camera_.fx = camera_.fy = 120, camera_.cx = 159.5, camera_.cy = 119.5;
    camera_.max_angle_rad = Radians(95);
    image_ = Frame(0);
    cv::imwrite(File("image.png"), image_);
    arguments_.camera = File("camera.yaml");
    arguments_.input = File("image.png");
    arguments_.out = File("out.png");
    arguments_.quiet = true;
  }

  std::string File(const char* name) const { return (folder_ / name).string(); }

  // Smooth, so that a video's compression changes it by few levels, and brighter by 10 levels each.
  static cv::Mat Frame(int k) {
    cv::Mat image(240, 320, CV_8UC3);
    for (int v = 0; v < 240; ++v) {
      for (int u = 0; u < 320; ++u)
        image.at<cv::Vec3b>(v, u) = cv::Vec3b(40 + u / 2, 200 - v / 2, 60 + 30 * k);
    }
    return image;
  }
  std::string Mistake() const {
    try {
      ViewCommand(arguments_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "none";
  }

  vision::KannalaBrandt camera_;
  cv::Mat image_;
  ViewArguments arguments_;
};

// A camera of 12 bits, whose files leave the upper four of 16 empty.
TEST_F(ViewCommandTest, TwelveBitsAreSeenAsEight) {
  ViewCommand(arguments_);
  const cv::Mat of_eight = cv::imread(arguments_.out);
  cv::Mat twelve;
  image_.convertTo(twelve, CV_16U, 16);
  cv::imwrite(arguments_.input, twelve);
  for (const std::optional<int> bits : {std::optional<int>(), std::optional(12)}) {
    arguments_.bits = bits;
    ViewCommand(arguments_);
    EXPECT_EQ(cv::norm(cv::imread(arguments_.out), of_eight, cv::NORM_INF), 0);
  }
  arguments_.bits = 10;
  EXPECT_THAT(Mistake(), HasSubstr("image.png: has values up to 3"));
  arguments_.bits.reset();
  arguments_.quiet = false;
  testing::internal::CaptureStdout();
  ViewCommand(arguments_);
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              HasSubstr("white is taken to be 4095; --bits N says it"));
}

TEST_F(ViewCommandTest, WritesTheViewThatWasAskedFor) {
  arguments_.yaw_deg = 20, arguments_.pitch_deg = -10, arguments_.roll_deg = 5, arguments_.fov_deg = 80;
  arguments_.size = "200x100";
  ViewCommand(arguments_);
  const double f = 100 / std::tan(Radians(40));
  const vision::View view = vision::PerspectiveView{
      {200, 100, f, f, 99.5, 49.5}, vision::ViewRotation(Radians(20), Radians(-10), Radians(5))};
  const cv::Mat expected = vision::Look(vision::MakeViewTable(view, camera_), image_);
  const cv::Mat written = cv::imread(arguments_.out);
  ASSERT_EQ(written.size(), expected.size());
  EXPECT_EQ(cv::norm(written, expected, cv::NORM_INF), 0);
}

TEST_F(ViewCommandTest, EveryKindHasASizeOfItsOwnThatFitsTheImage) {
  const std::pair<const char*, cv::Size> kinds[] = {
      {"perspective", {320, 240}}, {"polar", {501, 159}}, {"sphere", {800, 800}}};
  for (const auto& [as, size] : kinds) {
    arguments_.as = as;
    ViewCommand(arguments_);
    EXPECT_EQ(cv::imread(arguments_.out).size(), size) << as;
  }
  for (const char* as : {"panorama", "cylinder"}) {
    arguments_.as = as;
    arguments_.azimuth_deg = "-60..30.5", arguments_.elevation_deg = "-20..20";
    ViewCommand(arguments_);
    const cv::Size size = cv::imread(arguments_.out).size();
    const double px_per_rad = vision::MeanResolution(camera_);
    EXPECT_NEAR(size.width, Radians(90.5) * px_per_rad, 1) << as;
    EXPECT_NEAR(
        size.height,
        arguments_.as == "panorama" ? Radians(40) * px_per_rad : 2 * px_per_rad * std::tan(Radians(20)), 1)
        << as;
  }
}

TEST_F(ViewCommandTest, DoesNotOverwriteItsInput) {
  arguments_.out = arguments_.input;
  EXPECT_THAT(Mistake(), HasSubstr("--out: "));
  arguments_.out = (folder_ / "." / "image.png").string();
  EXPECT_THAT(Mistake(), HasSubstr("is the input itself"));
  fs::create_hard_link(arguments_.input, File("link.png"));
  arguments_.out = File("link.png");
  EXPECT_THAT(Mistake(), HasSubstr("is the input itself"));
  EXPECT_EQ(cv::norm(cv::imread(arguments_.input), image_, cv::NORM_INF), 0);
}

TEST_F(ViewCommandTest, AGreyImageGivesAGreyView) {
  cv::imwrite(File("grey.png"), cv::Mat(240, 320, CV_8UC1, cv::Scalar(77)));
  arguments_.input = File("grey.png");
  ViewCommand(arguments_);
  const cv::Mat written = cv::imread(arguments_.out, cv::IMREAD_UNCHANGED);
  EXPECT_EQ(written.type(), CV_8UC1);
  EXPECT_EQ(written.at<uchar>(120, 160), 77);
}

TEST_F(ViewCommandTest, TakesACalibrationOfKalibrAndOneOfOpenCvWithoutSize) {
  ViewCommand(arguments_);
  const cv::Mat expected = cv::imread(arguments_.out);
  std::ofstream(File("camchain.yaml"))
      << "cam0:\n  camera_model: pinhole\n  distortion_model: radtan\n  intrinsics: [400, 400, 10, 10]\n"
         "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [100, 100]\n"
         "cam1:\n  camera_model: pinhole\n  distortion_model: equidistant\n"
         "  intrinsics: [120, 120, 159.5, 119.5]\n  distortion_coeffs: [0, 0, 0, 0]\n"
         "  resolution: [320, 240]\n";
  arguments_.camera = File("camchain.yaml");
  arguments_.camera_name = "cam1";
  ViewCommand(arguments_);
  EXPECT_EQ(cv::norm(cv::imread(arguments_.out), expected, cv::NORM_INF), 0);
  std::ofstream(File("opencv.yml")) << "%YAML:1.0\n---\nfisheye_model: 1\n"
                                       "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                                       "   data: [120., 0., 159.5, 0., 120., 119.5, 0., 0., 1.]\n"
                                       "distortion_coefficients: !!opencv-matrix\n   rows: 4\n   cols: 1\n"
                                       "   dt: d\n   data: [0., 0., 0., 0.]\n";
  arguments_.camera = File("opencv.yml");
  arguments_.camera_name = "";
  ViewCommand(arguments_);
  EXPECT_EQ(cv::norm(cv::imread(arguments_.out), expected, cv::NORM_INF), 0);
}

TEST_F(ViewCommandTest, TurnsAVideoFrameByFrame) {
  records::Video video(File("video.mp4"), 12.5);
  for (int k = 0; k < 7; ++k) video.Write(Frame(k));
  video.Close();
  arguments_.input = File("video.mp4");
  arguments_.out = File("out.mp4");
  arguments_.as = "panorama";
  arguments_.azimuth_deg = "-30..30", arguments_.elevation_deg = "-20..20";
  arguments_.size = "160x90";
  ViewCommand(arguments_);

  records::VideoReader out(arguments_.out);
  EXPECT_EQ(out.size(), cv::Size(160, 90));
  EXPECT_DOUBLE_EQ(out.rate_hz(), 12.5);
  EXPECT_EQ(out.frames(), 7);
  const vision::View view = vision::Panorama{160,
                                             90,
                                             Radians(-30),
                                             Radians(30),
                                             Radians(-20),
                                             Radians(20),
                                             vision::Panorama::Rows::kElevation,
                                             Eigen::Matrix3d::Identity()};
  const vision::ViewTable table = vision::MakeViewTable(view, camera_);
  int frames = 0;
  for (; const auto frame = out.Next(); ++frames)
    EXPECT_LT(cv::norm(*frame, vision::Look(table, Frame(frames)), cv::NORM_L1) / (160 * 90 * 3), 5)
        << frames;
  EXPECT_EQ(frames, 7);
}

TEST_F(ViewCommandTest, SaysEveryMistakeOfTheArgumentsAtOnce) {
  arguments_.as = "panorama";
  arguments_.camera = "fisheyes_of_nobody";
  arguments_.input = File("none.png");
  arguments_.out = File("out.gif");
  arguments_.fov_deg = 90;
  arguments_.pitch_deg = 200;
  arguments_.size = "3x";
  arguments_.azimuth_deg = "10..-10";
  arguments_.elevation_deg = "-100..20";
  EXPECT_THAT(
      Mistake(),
      AllOf(HasSubstr("there is no camera 'fisheyes_of_nobody'"),
            HasSubstr("none.png: cannot be read: No such file"), HasSubstr("valid: an ending .png or .jpg"),
            HasSubstr("--fov-deg: means nothing for --as panorama"),
            HasSubstr("--pitch-deg: 200 is out of range"), HasSubstr("--size: '3x' is not a size"),
            HasSubstr("--azimuth-deg: '10..-10' falls"),
            HasSubstr("--elevation-deg: '-100..20' is not a range; valid: A..B within -90..90")));
  EXPECT_FALSE(fs::exists(arguments_.out));
}

TEST_F(ViewCommandTest, RefusesAFileThatIsNeitherImageNorVideo) {
  arguments_.input = File("camera.yaml");
  EXPECT_THAT(Mistake(), HasSubstr("camera.yaml: is neither an image nor a video"));
}

TEST_F(ViewCommandTest, RefusesAnImageOfAnotherSizeThanTheCalibration) {
  cv::imwrite(File("large.png"), cv::Mat(480, 640, CV_8UC3, cv::Scalar(1, 2, 3)));
  arguments_.input = File("large.png");
  EXPECT_THAT(Mistake(), AllOf(HasSubstr("camera.yaml"), HasSubstr("640 x 480"), HasSubstr("320 x 240")));
}

TEST_F(ViewCommandTest, RefusesAViewThatWouldBeBlack) {
  arguments_.yaw_deg = 180;
  EXPECT_THAT(Mistake(), AllOf(HasSubstr("would be black"), HasSubstr("95.0 deg")));
  EXPECT_FALSE(fs::exists(arguments_.out));
}

TEST_F(ViewCommandTest, ABrokenVideoIsNamed) {
  records::Video video(File("video.mp4"), 20);
  for (int k = 0; k < 3; ++k) video.Write(Frame(k));
  video.Close();
  fs::resize_file(File("video.mp4"), fs::file_size(File("video.mp4")) / 2);
  EXPECT_THROW(
      {
        records::VideoReader reader(File("video.mp4"));
        while (reader.Next()) {}
      },
      std::runtime_error);
}

}  // namespace
}  // namespace kestrel::app
