// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/calibration_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/diagnostics.h"
#include "base/yaml/config.h"

namespace kestrel::vision {
namespace {

using Eigen::VectorXd;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

struct Loaded {
  CameraModel camera;
  std::vector<std::string> messages;
};

Loaded Load(const std::string& text, const std::string& name = "",
            const std::optional<cv::Size>& image = {}) {
  Mistakes mistakes;
  const Config config = ParseConfig(text, "file.yaml", {}, mistakes);
  Loaded loaded;
  loaded.camera = ParseCamera(config, mistakes, name, image);
  loaded.messages = mistakes.Texts();
  return loaded;
}

template <class Camera>
void ExpectCamera(const Loaded& loaded, const Camera& expected) {
  ASSERT_THAT(loaded.messages, IsEmpty());
  ASSERT_STREQ(NameOf(loaded.camera), Camera::kName);
  EXPECT_EQ(Parameters(loaded.camera), expected.Parameters());
  EXPECT_EQ(WidthPx(loaded.camera), expected.width_px);
  EXPECT_EQ(HeightPx(loaded.camera), expected.height_px);
  EXPECT_NEAR(MaxAngle(loaded.camera), expected.MaxAngle(), 1e-15);
}

// As Kalibr writes it, with what belongs to the other cameras and to the IMU.
constexpr const char* kCamchain = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
  distortion_model: radtan
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.9999, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [0.0034823894, 0.0007150348, -0.0020532361, 0.0002029367]
  distortion_model: equi
  intrinsics: [190.978477, 190.973307, 254.931706, 256.897442]
  resolution: [512, 512]
  rostopic: /cam1/image_raw
cam2:
  camera_model: omni
  distortion_coeffs: [-0.3352, 0.1321, 0.00056, 0.00058]
  distortion_model: radtan
  intrinsics: [0.80065662, 833.006, 830.345, 373.85, 253.749]
  resolution: [752, 480]
cam3:
  camera_model: ds
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [-0.1996, 0.5925, 317.55, 316.17,
    724.86, 546.57]
  resolution: [1440, 1080]
)";

TEST(CalibrationFile, KalibrsCamchainLoadsAsItIs) {
  const BrownConrady radtan{752,     480,         458.654,    457.296,    367.215,
                            248.375, -0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  ExpectCamera(Load(kCamchain), radtan);
  ExpectCamera(Load(kCamchain, "cam0"), radtan);
  ExpectCamera(Load(kCamchain, "cam1"),
               KannalaBrandt{512, 512, 190.978477, 190.973307, 254.931706, 256.897442, 0.0034823894,
                             0.0007150348, -0.0020532361, 0.0002029367});
  ExpectCamera(Load(kCamchain, "cam2"), Unified{752, 480, 833.006, 830.345, 373.85, 253.749, 0.80065662,
                                                -0.3352, 0.1321, 0.00056, 0.00058});
  ExpectCamera(Load(kCamchain, "cam3"),
               DoubleSphere{1440, 1080, 317.55, 316.17, 724.86, 546.57, -0.1996, 0.5925});
  ExpectCamera(Load("%YAML:1.0\n" + std::string(kCamchain)), radtan);  // some put OpenCV's header above it
}

// What OpenCV's FileStorage writes, by OpenCV itself.
template <class... Values>
std::string OpenCvFile(const cv::Matx33d& K, const std::vector<double>& distortion, const Values&... pairs) {
  cv::FileStorage file("calibration.yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "calibration_time"
       << "Mon 03 Feb 2020 10:11:12";
  (file << ... << pairs);
  file << "camera_matrix" << cv::Mat(K) << "distortion_coefficients" << cv::Mat(distortion);
  file.writeComment("flags: +fix_aspectRatio");
  return file.releaseAndGetString();
}

const cv::Matx33d kMatrix(700.5, 0, 320.25, 0, 701.5, 240.75, 0, 0, 1);

TEST(CalibrationFile, OpenCvsFilesLoadAsTheyAre) {
  ExpectCamera(Load(OpenCvFile(kMatrix, {-0.2, 0.1, 1e-3, -2e-3, 0.01}, "image_width", 640, "image_height",
                               480, "fisheye_model", 0)),
               BrownConrady{640, 480, 700.5, 701.5, 320.25, 240.75, -0.2, 0.1, 1e-3, -2e-3, 0.01});
  ExpectCamera(Load(OpenCvFile(kMatrix, {-0.2, 0.1, 1e-3, -2e-3}, "image_width", 640, "image_height", 480,
                               "distortion_model", "plumb_bob")),
               BrownConrady{640, 480, 700.5, 701.5, 320.25, 240.75, -0.2, 0.1, 1e-3, -2e-3});
  ExpectCamera(Load(OpenCvFile(kMatrix, {-0.2, 0.1, 1e-3, -2e-3, 0.01, 0, 0, 0}, "image_width", 640,
                               "image_height", 480)),
               BrownConrady{640, 480, 700.5, 701.5, 320.25, 240.75, -0.2, 0.1, 1e-3, -2e-3, 0.01});
  ExpectCamera(Load(OpenCvFile(kMatrix, {-0.02, 0.01, -5e-3, 1e-3}, "image_width", 640, "image_height", 480,
                               "fisheye_model", true)),
               KannalaBrandt{640, 480, 700.5, 701.5, 320.25, 240.75, -0.02, 0.01, -5e-3, 1e-3});
}

TEST(CalibrationFile, OpenCvsOmnidirLoadsWithItsSkewAndTheSizeOfTheImages) {
  cv::Matx33d K = kMatrix;
  K(0, 1) = 1.5;
  Unified expected{640, 480, 700.5, 701.5, 320.25, 240.75, 1.2, -0.1, 0.01, 1e-3, -2e-3};
  expected.skew = 1.5;
  const std::vector<double> distortion{-0.1, 0.01, 1e-3, -2e-3};
  // OpenCV's own sample writes no size, and xi as a matrix.
  const std::string file = OpenCvFile(K, distortion, "xi", cv::Mat(cv::Matx<double, 1, 1>(1.2)));
  ExpectCamera(Load(file, "", cv::Size(640, 480)), expected);
  ExpectCamera(Load(OpenCvFile(K, distortion, "xi", 1.2), "", cv::Size(640, 480)), expected);
  EXPECT_THAT(Load(file).messages,
              ElementsAre(AllOf(HasSubstr("image_width, image_height"), HasSubstr("must be given"))));
}

TEST(CalibrationFile, RosCameraInfoLoads) {
  const std::string file =
      "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [700.5, 0, 320.25, 0, 701.5, 240.75, 0, 0, 1]\ndistortion_model: equidistant\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [-0.02, 0.01, -0.005, 0.001]\n";
  ExpectCamera(Load(file), KannalaBrandt{640, 480, 700.5, 701.5, 320.25, 240.75, -0.02, 0.01, -5e-3, 1e-3});
}

std::string RosFile(const std::string& model_lines,
                    const std::string& numbers = "-0.02, 0.01, -0.005, 0.001") {
  return "image_width: 640\nimage_height: 480\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
         "  data: [700.5, 0, 320.25, 0, 701.5, 240.75, 0, 0, 1]\n" +
         model_lines + "distortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [" + numbers + "]\n";
}

TEST(CalibrationFile, EveryWordOfAModelThatOthersWriteIsUnderstood) {
  for (const char* word :
       {"equidistant", "equi", "fisheye", "kannala_brandt", "KannalaBrandt", "KANNALA_BRANDT"})
    ExpectCamera(Load(RosFile(fmt::format("distortion_model: {}\n", word))),
                 KannalaBrandt{640, 480, 700.5, 701.5, 320.25, 240.75, -0.02, 0.01, -5e-3, 1e-3});
  for (const char* word : {"plumb_bob", "radtan", "radial-tangential", "rational_polynomial"})
    ExpectCamera(Load(RosFile(fmt::format("distortion_model: {}\n", word))),
                 BrownConrady{640, 480, 700.5, 701.5, 320.25, 240.75, -0.02, 0.01, -5e-3, 1e-3});
  ExpectCamera(Load(RosFile("camera_model: plumb_bob\n")),
               BrownConrady{640, 480, 700.5, 701.5, 320.25, 240.75, -0.02, 0.01, -5e-3, 1e-3});
  ExpectCamera(Load(RosFile("camera_model: pinhole\ndistortion_model: equidistant\n")),
               KannalaBrandt{640, 480, 700.5, 701.5, 320.25, 240.75, -0.02, 0.01, -5e-3, 1e-3});
  for (const char* word : {"mei", "omni", "omnidir"})
    ExpectCamera(Load(RosFile(fmt::format("distortion_model: {}\nxi: 1.2\n", word))),
                 Unified{640, 480, 700.5, 701.5, 320.25, 240.75, 1.2, -0.02, 0.01, -5e-3, 1e-3});
}

TEST(CalibrationFile, AModelThatIsNotKnownOrNotSaidIsRefusedAndNotTakenForAnother) {
  EXPECT_THAT(Load(RosFile("distortion_model: fov\n")).messages,
              ElementsAre(AllOf(StartsWith("file.yaml:7: distortion_model: 'fov' is not known"),
                                HasSubstr("plumb_bob"), HasSubstr("equidistant"))));
  EXPECT_THAT(Load(RosFile("distortion_model: mei\n")).messages,
              ElementsAre(AllOf(HasSubstr("xi: must be given"), HasSubstr("'mei'"))));
  EXPECT_THAT(Load(RosFile("")).messages,
              ElementsAre(AllOf(HasSubstr("distortion_model: must be given"), HasSubstr("plumb_bob"),
                                HasSubstr("equidistant"))));
  EXPECT_THAT(Load(RosFile("distortion_model: plumb_bob\nfisheye_model: 1\n")).messages,
              ElementsAre(AllOf(StartsWith("file.yaml:8: fisheye_model"), HasSubstr("kannala_brandt"),
                                HasSubstr("brown_conrady"))));
  EXPECT_THAT(Load(RosFile("distortion_model: equidistant\nfisheye_model: 0\n")).messages,
              ElementsAre(HasSubstr("fisheye_model")));
  EXPECT_THAT(Load(RosFile("distortion_model: equidistant\nxi: 1.2\n")).messages,
              ElementsAre(HasSubstr("xi")));
  EXPECT_THAT(Load(RosFile("fisheye_model: 2\n")).messages,
              ElementsAre(AllOf(HasSubstr("fisheye_model: '2' is not valid"), HasSubstr("0, 1"))));
}

TEST(CalibrationFile, FiveCoefficientsCanOnlyBeThoseOfCalibrateCamera) {
  ExpectCamera(Load(RosFile("", "-0.2, 0.1, 1e-3, -2e-3, 0.01")),
               BrownConrady{640, 480, 700.5, 701.5, 320.25, 240.75, -0.2, 0.1, 1e-3, -2e-3, 0.01});
}

// Every model with every parameter different from its default.
std::vector<CameraModel> Cameras() {
  Pinhole narrow{640, 480, 810.81, 800.1, 319.4, 239.6};
  narrow.max_angle_rad = Radians(31);
  Unified skewed{640, 480, 250.1, 251.2, 319.4, 239.6, 0.97, -0.1, 0.02, 1e-3, -3e-4};
  skewed.skew = 0.7, skewed.max_angle_rad = Radians(100);
  return {narrow, BrownConrady{640, 480, 457.1, 458.3, 319.4, 239.6, -0.3, 0.1, 1e-4, 2e-4, -0.01}, skewed,
          KannalaBrandt{640, 480, 190.1, 191.7, 319.4, 239.6, -0.01, 0.02, -0.01, 0.002},
          DoubleSphere{640, 480, 180.1, 181.4, 319.4, 239.6, -0.2, 0.6}};
}

void ExpectSame(const CameraModel& a, const CameraModel& b) {
  EXPECT_STREQ(NameOf(a), NameOf(b));
  EXPECT_EQ(Parameters(a), Parameters(b));
  EXPECT_EQ(WidthPx(a), WidthPx(b));
  EXPECT_EQ(HeightPx(a), HeightPx(b));
  EXPECT_NEAR(MaxAngle(a), MaxAngle(b), 1e-15);
}

TEST(CalibrationFile, EveryModelReadsBackFromItsOwnFile) {
  for (const CameraModel& camera : Cameras()) {
    const Loaded loaded = Load(ToCameraYaml(camera));
    EXPECT_THAT(loaded.messages, IsEmpty()) << ToCameraYaml(camera);
    ExpectSame(loaded.camera, camera);
  }
}

TEST(CalibrationFile, EveryModelReadsBackFromKalibrsFile) {
  for (CameraModel camera : Cameras()) {
    if (auto* brown = std::get_if<BrownConrady>(&camera)) brown->k3 = 0;
    if (auto* unified = std::get_if<Unified>(&camera)) unified->skew = 0;
    const Loaded loaded = Load(ToKalibr(camera));
    EXPECT_THAT(loaded.messages, IsEmpty()) << ToKalibr(camera);
    ExpectSame(loaded.camera, camera);
  }
}

TEST(CalibrationFile, WhatKalibrCannotSayIsRefused) {
  EXPECT_THROW(ToKalibr(Cameras()[1]), InputError);  // k3
  EXPECT_THROW(ToKalibr(Cameras()[2]), InputError);  // skew
}

std::string Replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

TEST(CalibrationFile, MistakesInACamchainNameLineCameraAndParameter) {
  EXPECT_THAT(Load(Replaced(kCamchain, "458.654", "-458")).messages,
              ElementsAre("file.yaml:6: cam0.fx_px: -458 is out of range; valid: 1 to 100000"));
  EXPECT_THAT(Load(Replaced(kCamchain, "[458.654, ", "[")).messages,
              ElementsAre(AllOf(StartsWith("file.yaml:6: cam0.intrinsics: 3 numbers are not valid"),
                                HasSubstr("fx_px, fy_px, cx_px, cy_px"))));
  EXPECT_THAT(
      Load(Replaced(kCamchain, "0.80065662", "-0.1"), "cam2").messages,
      ElementsAre(AllOf(StartsWith("file.yaml:26: cam2.xi: -0.1 is out of range"), HasSubstr("0 to 20"))));
  EXPECT_THAT(Load(Replaced(kCamchain, "0.5925", "1.4"), "cam3").messages,
              ElementsAre(StartsWith("file.yaml:32: cam3.alpha: 1.4 is out of range; valid: 0 to 1")));
  EXPECT_THAT(Load(Replaced(kCamchain, "  resolution: [752, 480]\n", "")).messages,
              ElementsAre(StartsWith("file.yaml:1: cam0.resolution: must be given")));
  EXPECT_THAT(
      Load(Replaced(kCamchain, "radtan", "atan")).messages,
      ElementsAre(AllOf(StartsWith("file.yaml:3: cam0.camera_model: 'pinhole' with distortion_model 'atan'"),
                        HasSubstr("omni-radtan"))));
  EXPECT_THAT(Load(kCamchain, "cam7").messages, ElementsAre(HasSubstr("cam0, cam1, cam2, cam3")));
  EXPECT_THAT(Load(Replaced(Replaced(kCamchain, "458.654", "zero"), "0.07395907", ".nan")).messages,
              ElementsAre(HasSubstr("fx_px"), HasSubstr("k2")));  // all at once
}

TEST(CalibrationFile, MistakesInAnOpenCvFileNameTheParameter) {
  const auto with = [](const cv::Matx33d& K, const std::vector<double>& distortion) {
    return Load(OpenCvFile(K, distortion, "image_width", 640, "image_height", 480)).messages;
  };
  cv::Matx33d K = kMatrix;
  K(1, 1) = 0;
  EXPECT_THAT(with(K, {0, 0, 0, 0, 0}), ElementsAre(HasSubstr("fy_px: 0. is out of range")));
  K = kMatrix, K(0, 1) = 3;  // a skew, which only omnidir knows
  EXPECT_THAT(with(K, {0, 0, 0, 0, 0}),
              ElementsAre(HasSubstr("camera_matrix.data.1: '3.' is not valid; valid: 0")));
  EXPECT_THAT(with(kMatrix, {0, 0, 0, 0, 0, 0, 0, 0, 0.5, 0.5, 0, 0}),
              ElementsAre(AllOf(HasSubstr("distortion_coefficients.data.8"), HasSubstr("thin prism"))));
  EXPECT_THAT(with(kMatrix, {0, 0, 0}), ElementsAre(HasSubstr("3 numbers are not valid")));
  EXPECT_THAT(
      Load(OpenCvFile(kMatrix, {0, 0, 0, 0}, "xi", 25.0, "image_width", 640, "image_height", 480)).messages,
      ElementsAre(AllOf(HasSubstr("xi: 25. is out of range"), HasSubstr("0 to 20"))));
  EXPECT_THAT(Load("camera_matrix: 7\nimage_width: 640\nimage_height: 480\n").messages,
              ElementsAre(AllOf(HasSubstr("camera_matrix"), HasSubstr("9 numbers")),
                          AllOf(HasSubstr("distortion_coefficients"), HasSubstr("must be given"))));
}

TEST(CalibrationFile, MistakesInOnesOwnFileAreNamed) {
  const std::string file = ToCameraYaml(Cameras()[2]);
  EXPECT_THAT(Load(Replaced(file, "unified", "unifed")).messages,
              ::testing::Contains(HasSubstr("did you mean 'unified'?")));
  EXPECT_THAT(Load(Replaced(file, "xi: 0.97", "ix: 0.97")).messages,
              ElementsAre("file.yaml:1: xi: must be given", HasSubstr("ix: unknown key")));
  EXPECT_THAT(Load("width: 3\nheight: 4\n").messages, ElementsAre(HasSubstr("is not a camera")));
  EXPECT_THAT(Load(file, "cam1").messages, ElementsAre(HasSubstr("cam1: there is no such camera")));
}

TEST(CalibrationFile, ImagesOfAnotherSizeAreRefused) {
  EXPECT_THAT(Load(kCamchain, "", cv::Size(752, 480)).messages, IsEmpty());
  EXPECT_THAT(Load(kCamchain, "", cv::Size(376, 240)).messages,
              ElementsAre(AllOf(StartsWith("file.yaml:7:"), HasSubstr("752 x 480"), HasSubstr("376 x 240"))));
}

TEST(CalibrationFile, ALensThatShowsNothingInTheImageIsRefused) {
  EXPECT_THAT(
      Load("width_px: 640\nheight_px: 480\nfx_px: 500\nfy_px: 500\ncx_px: -5000\ncy_px: 240\nfield_deg: 60\n")
          .messages,
      ElementsAre(AllOf(HasSubstr("no pixel of the image"), HasSubstr("30 deg"))));
}

TEST(CalibrationFile, ALensThatFillsAPartOfTheImageIsFine) {
  const Loaded loaded = Load(
      "model: kannala_brandt\nwidth_px: 640\nheight_px: 480\nfx_px: 150\nfy_px: 150\ncx_px: 319.5\ncy_px: "
      "239.5\nfield_deg: 160\n");
  EXPECT_THAT(loaded.messages, IsEmpty());
  // A circle of radius 150 px * 80 deg.
  const double radius = 150 * Radians(80);
  EXPECT_NEAR(ShareCovered(loaded.camera), M_PI * radius * radius / (640 * 480), 0.02);
  EXPECT_EQ(ShareCovered(Pinhole{640, 480, 500, 500, 320, 240}), 1);
}

TEST(CalibrationFile, ACameraOfTheModelsFolderLoadsFromItsFile) {
  Mistakes mistakes;
  const CameraModel camera =
      LoadCamera(std::filesystem::path(KESTREL_SOURCE_DIR) / "models/cameras/thesis_6mm.yaml", mistakes);
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  ExpectSame(camera, Pinhole{640, 480, 810.81, 810.81, 319.5, 239.5});
  LoadCamera("nowhere.yaml", mistakes);
  EXPECT_THAT(mistakes.Texts(), ElementsAre(HasSubstr("nowhere.yaml: cannot be read")));
}

TEST(CalibrationFile, TheFisheyeOfTheModelsFolderFillsItsImageTo190Degrees) {
  Mistakes mistakes;
  const CameraModel camera =
      LoadCamera(std::filesystem::path(KESTREL_SOURCE_DIR) / "models/cameras/fisheye.yaml", mistakes);
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  EXPECT_EQ(ShareCovered(camera), 1);
  const auto corner = Ray(camera, {0, 0});
  ASSERT_TRUE(corner);
  EXPECT_NEAR(2 * Degrees(AngleFromAxis(*corner)), 190, 0.5);
}

}  // namespace
}  // namespace kestrel::vision
