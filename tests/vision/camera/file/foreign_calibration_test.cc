// SPDX-License-Identifier: Apache-2.0
// Calibrations in the published form of each program, against OpenCV's own projection or the published formula.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/ccalib/omnidir.hpp>

#include "base/diagnostics.h"
#include "base/yaml/config.h"
#include "tests/support/temporary_folder.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::vision {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct ReadCamera {
  CameraModel camera;
  std::vector<std::string> messages, names;
};

class ForeignCalibration : public InTemporaryFolder {
 protected:
  ReadCamera Read(const std::string& text, const std::string& name = "",
                  const std::optional<cv::Size>& image = {}) const {
    std::ofstream(folder_ / "file") << text;
    Mistakes mistakes;
    ReadCamera read;
    read.camera = LoadCamera(folder_ / "file", mistakes, name, image);
    read.messages = mistakes.Texts();
    return read;
  }
};

// Points in front of the camera, up to some 45 degrees from its axis.
std::vector<cv::Vec3d> Points() {
  std::vector<cv::Vec3d> points;
  for (double x = -0.9; x < 1; x += 0.2)
    for (double y = -0.7; y < 0.8; y += 0.2) points.emplace_back(3 * x, 3 * y, 3);
  return points;
}

// To 1e-6 px where the image is.
void ExpectPixels(const ReadCamera& read, const std::vector<cv::Vec2d>& oracle) {
  ASSERT_THAT(read.messages, IsEmpty());
  const auto points = Points();
  ASSERT_EQ(points.size(), oracle.size());
  int compared = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Vec2d& uv = oracle[i];
    if (!(uv[0] >= 0 && uv[1] >= 0 && uv[0] < WidthPx(read.camera) && uv[1] < HeightPx(read.camera)))
      continue;
    const auto own = Project(read.camera, {points[i][0], points[i][1], points[i][2]});
    ASSERT_TRUE(own) << points[i];
    EXPECT_LT(std::hypot(own->x() - uv[0], own->y() - uv[1]), 1e-6) << points[i];
    ++compared;
  }
  EXPECT_GT(compared, 20);
}

const cv::Vec3d kZero(0, 0, 0);
cv::Matx33d Matrix(double fx, double fy, double cx, double cy) { return {fx, 0, cx, 0, fy, cy, 0, 0, 1}; }

std::vector<cv::Vec2d> ByCalibrateCamera(const cv::Matx33d& K, const std::vector<double>& distortion) {
  std::vector<cv::Vec2d> pixels;
  cv::projectPoints(Points(), kZero, kZero, K, distortion, pixels);
  return pixels;
}
std::vector<cv::Vec2d> ByFisheye(const cv::Matx33d& K, const cv::Vec4d& distortion) {
  std::vector<cv::Vec2d> pixels;
  cv::fisheye::projectPoints(Points(), pixels, kZero, kZero, K, distortion);
  return pixels;
}
std::vector<cv::Vec2d> ByOmnidir(const cv::Matx33d& K, double xi, const cv::Vec4d& distortion) {
  std::vector<cv::Vec2d> pixels;
  cv::omnidir::projectPoints(Points(), pixels, kZero, kZero, K, xi, distortion);
  return pixels;
}
std::vector<cv::Vec2d> ByFormula(const std::function<cv::Vec2d(double x, double y, double z)>& pixel) {
  std::vector<cv::Vec2d> pixels;
  for (const cv::Vec3d& p : Points()) pixels.push_back(pixel(p[0], p[1], p[2]));
  return pixels;
}

const cv::Matx33d kK = Matrix(458.5, 457.25, 367.5, 248.25);
const std::vector<double> kRadtan{-0.28, 0.07, 2e-4, 1.8e-5};
const std::vector<double> kEight{0.3, 0.05, 1e-3, -1e-3, 0.01, 0.5, 0.1, 0.02};
const cv::Vec4d kEqui(-0.003, 0.014, -0.017, 0.012);

TEST_F(ForeignCalibration, RosRationalHasItsEightCoefficients) {
  const cv::Matx33d K = Matrix(611.9, 611.8, 637, 369);
  const std::vector<double> D{0.546, -2.601, 8.5e-4, -3.7e-4, 1.468, 0.4245, -2.430, 1.400};
  const std::string numbers = "0.546, -2.601, 8.5e-4, -3.7e-4, 1.468, 0.4245, -2.430, 1.400";
  ExpectPixels(Read("image_width: 1280\nimage_height: 720\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
                    "  data: [611.9, 0, 637, 0, 611.8, 369, 0, 0, 1]\n"
                    "distortion_model: rational_polynomial\ndistortion_coefficients: [" +
                    numbers + "]\n"),
               ByCalibrateCamera(K, D));
  // As rostopic prints it, message after message.
  const std::string message =
      "header: \n  seq: 82\nheight: 720\nwidth: 1280\n"
      "distortion_model: \"rational_polynomial\"\nD: [" +
      numbers + "]\nK: [611.9, 0.0, 637.0, 0.0, 611.8, 369.0, 0.0, 0.0, 1.0]\n---\n";
  ExpectPixels(Read(message), ByCalibrateCamera(K, D));
  ExpectPixels(Read(message + message), ByCalibrateCamera(K, D));
}

TEST_F(ForeignCalibration, OpenCvsXmlIsReadAsItsYaml) {
  const auto write = [](bool fisheye) {
    cv::FileStorage file("camera.xml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    file << "image_width" << 752 << "image_height" << 480 << "fisheye_model" << (fisheye ? 1 : 0)
         << "camera_matrix" << cv::Mat(kK) << "distortion_coefficients"
         << (fisheye ? cv::Mat(kEqui) : cv::Mat(kRadtan)) << "image_points" << cv::Mat(20, 40, CV_32FC2, 7.0);
    return file.releaseAndGetString();
  };
  ExpectPixels(Read(write(true)), ByFisheye(kK, kEqui));
  ExpectPixels(Read(write(false)), ByCalibrateCamera(kK, kRadtan));
  EXPECT_THAT(Read("<?xml version=\"1.0\"?>\n<opencv_storage>\n<imageSize>640 480</imageSize>\n"
                   "</opencv_storage>\n")
                  .messages,
              ElementsAre(HasSubstr("is not a camera")));
  EXPECT_THAT(Read("<?xml version=\"1.0\"?>\n<html></html>\n").messages,
              ElementsAre(HasSubstr("is XML, but")));
  EXPECT_THAT(Read("<?xml version=\"1.0\"?>\n<opencv_storage>\n<a>\n").messages,
              ElementsAre(HasSubstr("XML")));
}

TEST_F(ForeignCalibration, AStereoFileOfOpenCvHasTwoCameras) {
  cv::FileStorage file("stereo.yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  const std::vector<double> left{-0.055, 0.078, 0, 0, -0.14, 0, 0, -0.141, 0, 0, 0, 0, 0, 0},
      right{-0.2, 0.1, 0, 0, 0};
  const cv::Matx33d other = Matrix(500, 501, 330, 250);
  file << "M1" << cv::Mat(kK) << "D1" << cv::Mat(left) << "M2" << cv::Mat(other) << "D2" << cv::Mat(right);
  const std::string text = file.releaseAndGetString();
  const cv::Size size(752, 480);
  ExpectPixels(Read(text, "", size), ByCalibrateCamera(kK, left));
  ExpectPixels(Read(text, "cam1", size), ByCalibrateCamera(other, right));
  EXPECT_THAT(Read(text).messages, ElementsAre(AllOf(HasSubstr("image_width"), HasSubstr("must be given"))));
  EXPECT_THAT(Read(text, "cam2", size).messages, ElementsAre(HasSubstr("valid: cam0, cam1")));
}

// Devernay and Faugeras: the distorted radius is atan(2 r tan(w / 2)) / w.
TEST_F(ForeignCalibration, KalibrsFovIsTheModelOfDevernayAndFaugeras) {
  ExpectPixels(Read("cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.962]\n  distortion_model: fov\n"
                    "  intrinsics: [334.25, 333.5, 368.25, 252.5]\n  resolution: [752, 480]\n"),
               ByFormula([](double x, double y, double z) {
                 const double r = std::hypot(x, y) / z;
                 const double scale = std::atan(2 * r * std::tan(0.962 / 2)) / 0.962 / (r * z);
                 return cv::Vec2d(334.25 * scale * x + 368.25, 333.5 * scale * y + 252.5);
               }));
}

// Khomutenko et al., by OpenCV's sphere: the ellipsoid is one once x and y are drawn out by sqrt(beta).
std::vector<cv::Vec2d> ByEllipsoid(double fx, double fy, double cx, double cy, double alpha, double beta) {
  const double out = std::sqrt(beta), xi = alpha / (1 - alpha);
  std::vector<cv::Vec3d> points = Points();
  for (cv::Vec3d& p : points) p = {out * p[0], out * p[1], p[2]};
  std::vector<cv::Vec2d> pixels;
  cv::omnidir::projectPoints(points, pixels, kZero, kZero,
                             Matrix(fx / (1 - alpha) / out, fy / (1 - alpha) / out, cx, cy), xi,
                             cv::Vec4d(0, 0, 0, 0));
  return pixels;
}

TEST_F(ForeignCalibration, EucmOfKalibrAndOfBasaltIsTheModelOfKhomutenko) {
  const auto oracle = ByEllipsoid(460.75, 459.5, 365.75, 249.25, 0.59, 1.127);
  ExpectPixels(Read("cam0:\n  camera_model: eucm\n  distortion_coeffs: []\n  distortion_model: none\n"
                    "  intrinsics: [0.59, 1.127, 460.75, 459.5, 365.75, 249.25]\n  resolution: [752, 480]\n"),
               oracle);
  const std::string json =
      R"({"value0": {"T_imu_cam": [], "intrinsics": [
        {"camera_type": "ds", "intrinsics": {"fx": 350, "fy": 349, "cx": 366, "cy": 249, "xi": -0.24, "alpha": 0.567}},
        {"camera_type": "eucm", "intrinsics":
          {"fx": 460.75, "fy": 459.5, "cx": 365.75, "cy": 249.25, "alpha": 0.59, "beta": 1.127}},
        {"camera_type": "ucm", "intrinsics": {"fx": 460.75, "fy": 459.5, "cx": 365.75, "cy": 249.25, "alpha": 0.59}},
        {"camera_type": "rectilinear", "intrinsics": {"fx": 460, "fy": 459, "cx": 365, "cy": 249}}],
        "resolution": [[752, 480], [752, 480], [752, 480], [752, 480]]}})";
  ExpectPixels(Read(json, "cam1"), oracle);
  ExpectPixels(Read(json, "cam2"), ByEllipsoid(460.75, 459.5, 365.75, 249.25, 0.59, 1));
  const ReadCamera ds = Read(json);
  ASSERT_THAT(ds.messages, IsEmpty());
  EXPECT_EQ(Parameters(ds.camera), (Eigen::VectorXd(6) << 350, 349, 366, 249, -0.24, 0.567).finished());
  EXPECT_THAT(
      Read(json, "cam3").messages,
      ElementsAre(AllOf(HasSubstr("cam3.camera_type: 'rectilinear' is not known"), HasSubstr("eucm"))));
}

TEST_F(ForeignCalibration, BasaltHasOtherLensesToo) {
  const auto file = [](const std::string& type, const std::string& own) {
    return R"({"value0": {"intrinsics": [{"camera_type": ")" + type +
           R"(", "intrinsics": {"fx": 458.5, "fy": 457.25, "cx": 367.5, "cy": 248.25)" + own +
           R"(}}], "resolution": [[752, 480]]}})";
  };
  ExpectPixels(Read(file("kb4", R"(, "k1": -0.003, "k2": 0.014, "k3": -0.017, "k4": 0.012)")),
               ByFisheye(kK, kEqui));
  ExpectPixels(Read(file("pinhole", "")), ByCalibrateCamera(kK, {0, 0, 0, 0}));
  ExpectPixels(Read(file("pinhole-radtan8", R"(, "k1": 0.3, "k2": 0.05, "p1": 1e-3, "p2": -1e-3, "k3": 0.01,
                                              "k4": 0.5, "k5": 0.1, "k6": 0.02, "rpmax": 0)")),
               ByCalibrateCamera(kK, kEight));
}

TEST_F(ForeignCalibration, BasaltsCamerasMayBeYaml) {
  const ReadCamera read = Read(
      "camera_0:\n  camera_type: ds\n  intrinsics:\n    - fx: 321.5\n      fy: 322\n"
      "      cx: 657\n      cy: 530\n      xi: -0.03\n      alpha: 0.62\n"
      "  resolution:\n    - [1280, 1024]\nT_BS:\n  cols: 4\n");
  ASSERT_THAT(read.messages, IsEmpty());
  EXPECT_STREQ(NameOf(read.camera), "double_sphere");
  EXPECT_EQ(Parameters(read.camera), (Eigen::VectorXd(6) << 321.5, 322, 657, 530, -0.03, 0.62).finished());
}

std::string VinsFile(const std::string& type, const std::string& parameters) {
  return "%YAML:1.0\n---\nmodel_type: " + type +
         "\ncamera_name: camera\nimage_width: 752\nimage_height: 480\n" + parameters;
}

TEST_F(ForeignCalibration, VinsHasPinholeMeiAndKannalaBrandt) {
  const std::string radtan =
      "distortion_parameters:\n   k1: -0.28\n   k2: 0.07\n   p1: 2e-4\n   p2: 1.8e-5\n";
  ExpectPixels(Read(VinsFile("PINHOLE", radtan + "projection_parameters:\n   fx: 458.5\n   fy: 457.25\n"
                                                 "   cx: 367.5\n   cy: 248.25\n")),
               ByCalibrateCamera(kK, kRadtan));
  ExpectPixels(Read(VinsFile("MEI", "mirror_parameters:\n   xi: 1.5\n" + radtan +
                                        "projection_parameters:\n   gamma1: 900\n   gamma2: 901\n   u0: 361\n"
                                        "   v0: 248\n")),
               ByOmnidir(Matrix(900, 901, 361, 248), 1.5, {-0.28, 0.07, 2e-4, 1.8e-5}));
  ExpectPixels(Read(VinsFile("KANNALA_BRANDT",
                             "projection_parameters:\n   k2: -0.003\n   k3: 0.014\n   k4: -0.017\n"
                             "   k5: 0.012\n   mu: 458.5\n   mv: 457.25\n   u0: 367.5\n   v0: 248.25\n")),
               ByFisheye(kK, kEqui));
  ExpectPixels(Read(VinsFile("PINHOLE_FULL",
                             "distortion_parameters:\n   k1: 0.3\n   k2: 0.05\n   k3: 0.01\n"
                             "   k4: 0.5\n   k5: 0.1\n   k6: 0.02\n   p1: 1e-3\n   p2: -1e-3\n"
                             "projection_parameters:\n   fx: 458.5\n   fy: 457.25\n"
                             "   cx: 367.5\n   cy: 248.25\n")),
               ByCalibrateCamera(kK, kEight));
  EXPECT_THAT(Read(VinsFile("SCARAMUZZA", "projection_parameters:\n   p0: 1\n")).messages,
              ElementsAre(AllOf(HasSubstr("model_type: 'SCARAMUZZA' is not known"), HasSubstr("MEI"))));
  EXPECT_THAT(Read(VinsFile("PINHOLE", radtan + "projection_parameters:\n   fx: 458\n")).messages,
              ElementsAre(HasSubstr("fy, cx, cy: must be given")));
}

std::string OrbFile(const std::string& group, const std::string& more) {
  std::string text = "%YAML:1.0\n";
  for (const char* pair : {"fx: 458.5", "fy: 457.25", "cx: 367.5", "cy: 248.25"})
    text += group + "." + pair + "\n";
  return text + more + "Camera.fps: 20.0\nViewer.PointSize:2\nORBextractor.nFeatures: 1000\n";
}

TEST_F(ForeignCalibration, OrbSlamIsAPinholeUnlessItSaysOtherwise) {
  const std::string radtan = "Camera.k1: -0.28\nCamera.k2: 0.07\nCamera.p1: 0.0002\nCamera.p2: 1.8e-05\n";
  const std::string size = "Camera.width: 752\nCamera.height: 480\n";
  ExpectPixels(Read(OrbFile("Camera", radtan + size)), ByCalibrateCamera(kK, kRadtan));
  ExpectPixels(Read(OrbFile("Camera", radtan), "", cv::Size(752, 480)), ByCalibrateCamera(kK, kRadtan));
  EXPECT_THAT(Read(OrbFile("Camera", radtan)).messages,
              ElementsAre(AllOf(HasSubstr("Camera.width, Camera.height"), HasSubstr("must be given"))));
  const auto equi = [](const std::string& group) {
    std::string text;
    for (const char* pair : {"k1: -0.003", "k2: 0.014", "k3: -0.017", "k4: 0.012"})
      text += group + "." + pair + "\n";
    return text;
  };
  ExpectPixels(Read(OrbFile("Camera", "Camera.type: \"KannalaBrandt8\"\n" + equi("Camera") + size)),
               ByFisheye(kK, kEqui));
  ExpectPixels(Read(OrbFile("Camera1", "File.version: \"1.0\"\nCamera.type: \"KannalaBrandt8\"\n" +
                                           equi("Camera1") + size)),
               ByFisheye(kK, kEqui));
  EXPECT_THAT(Read(OrbFile("Camera", equi("Camera") + size)).messages,
              ElementsAre(AllOf(HasSubstr("Camera.type: must be given"), HasSubstr("KannalaBrandt8"))));
  EXPECT_THAT(Read(OrbFile("Camera", "Camera.type: \"Equirectangular\"\n" + size)).messages,
              ElementsAre(HasSubstr("Camera.type: 'Equirectangular' is not known")));
}

std::string AslamCamera(const std::string& type, const std::string& distortion, const std::string& numbers) {
  return "  - camera:\n      label: cam\n      image_height: 480\n      image_width: 752\n      type: " +
         type +
         "\n      intrinsics:\n        cols: 1\n        rows: 4\n        data: [458.5, 457.25, 367.5, "
         "248.25]\n"
         "      distortion:\n        type: " +
         distortion + "\n        parameters:\n          cols: 1\n          rows: 4\n          data: [" +
         numbers + "]\n";
}

TEST_F(ForeignCalibration, SvoAndMaplabListTheirCameras) {
  const std::string two = "cameras:\n" +
                          AslamCamera("pinhole", "radial-tangential  ", "-0.28, 0.07, 2e-4, 1.8e-5") +
                          AslamCamera("pinhole", "equidistant", "-0.003, 0.014, -0.017, 0.012");
  ExpectPixels(Read("label: Euroc\n" + two), ByCalibrateCamera(kK, kRadtan));
  ExpectPixels(Read("label: Euroc\n" + two, "cam1"), ByFisheye(kK, kEqui));
  std::string within =
      "sensors:\n  - id: 5d2f\n    sensor_type: IMU\n  - id: 8af1\n    sensor_type: NCAMERA\n    ";
  for (const char c : two) within += c == '\n' ? std::string("\n    ") : std::string(1, c);
  ExpectPixels(Read(within + "\n", "cam1"), ByFisheye(kK, kEqui));
  std::string sphere =
      "cameras:\n" + AslamCamera("unified-projection", "radial-tangential", "-0.28, 0.07, 2e-4, 1.8e-5");
  sphere.insert(sphere.find("458.5"), "1.5, ");
  ExpectPixels(Read(sphere), ByOmnidir(kK, 1.5, {-0.28, 0.07, 2e-4, 1.8e-5}));
  // Its word for the distortion of one number, as Kalibr's fov.
  const ReadCamera fov = Read("cameras:\n" + AslamCamera("pinhole", "fisheye", "0.9"));
  ASSERT_THAT(fov.messages, IsEmpty());
  EXPECT_STREQ(NameOf(fov.camera), "fov");
  EXPECT_EQ(Parameters(fov.camera)[4], 0.9);
  EXPECT_THAT(Read("cameras:\n" + AslamCamera("omni", "none", "")).messages,
              ElementsAre(AllOf(HasSubstr("cam0.type: 'omni' with the distortion 'none'"),
                                HasSubstr("pinhole, equidistant"))));
  EXPECT_THAT(Read("cameras:\n" + AslamCamera("pinhole", "equidistant", "1, 2")).messages,
              ElementsAre(HasSubstr("parameters: 2 numbers are not valid")));
}

TEST_F(ForeignCalibration, OkvisHasItsTypesOfDistortion) {
  const auto file = [](const std::string& type, const std::string& numbers) {
    return "cameras:\n     - {T_SC:\n        [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],\n"
           "        image_dimension: [752, 480],\n        distortion_coefficients: [" +
           numbers + "],\n        distortion_type: " + type +
           ",\n        focal_length: [458.5, 457.25],\n        principal_point: [367.5, 248.25]}\n"
           "imu_params:\n    a_max: 176.0\n";
  };
  ExpectPixels(Read("%YAML:1.0\n" + file("radialtangential", "-0.28, 0.07, 2e-4, 1.8e-5")),
               ByCalibrateCamera(kK, kRadtan));
  ExpectPixels(Read(file("equidistant", "-0.003, 0.014, -0.017, 0.012")), ByFisheye(kK, kEqui));
  ExpectPixels(Read(file("radialtangential8", "0.3, 0.05, 1e-3, -1e-3, 0.01, 0.5, 0.1, 0.02")),
               ByCalibrateCamera(kK, kEight));
  EXPECT_THAT(Read(file("ellipsoid", "1")).messages,
              ElementsAre(HasSubstr("cam0.distortion_type: 'ellipsoid' is not known")));
}

// Half a turn about z and a shift, with the camera at (0.1, 0.2, 0.3) of the IMU, as each program writes it.
TEST_F(ForeignCalibration, ThePlaceOnTheImuIsThatOfTheFile) {
  const std::string imu_cam = "[[-1, 0, 0, 0.1], [0, -1, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]]",
                    cam_imu = "[[-1, 0, 0, 0.1], [0, -1, 0, 0.2], [0, 0, 1, -0.3], [0, 0, 0, 1]]";
  const std::string kalibr =
      "cam0:\n  camera_model: pinhole\n  distortion_coeffs: []\n  distortion_model: none\n"
      "  intrinsics: [334.25, 333.5, 368.25, 252.5]\n  resolution: [752, 480]\n  ";
  const std::string basalt =
      R"({"value0": {"T_imu_cam": [{"px": 0.1, "py": 0.2, "pz": 0.3, "qx": 0, "qy": 0, "qz": 1, "qw": 0}],
          "intrinsics": [{"camera_type": "pinhole", "intrinsics": {"fx": 1, "fy": 1, "cx": 1, "cy": 1}}]}})";
  for (const std::string& text :
       {kalibr + "T_cam_imu: " + cam_imu + "\n", kalibr + "T_imu_cam: " + imu_cam + "\n", basalt,
        OrbFile("Camera",
                "Tbc: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: f\n"
                "  data: [-1, 0, 0, 0.1, 0, -1, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"),
        "cameras:\n" + AslamCamera("pinhole", "none", "") + "    T_B_C: " + imu_cam + "\n",
        "cameras:\n  - {T_SC: " + imu_cam +
            ", focal_length: [1, 1], principal_point: [1, 1], "
            "distortion_type: none}\n"}) {
    std::ofstream(folder_ / "file") << text;
    Mistakes mistakes;
    const auto X_IC = LoadPoseOnImu(folder_ / "file", mistakes);
    EXPECT_THAT(mistakes.Texts(), IsEmpty());
    ASSERT_TRUE(X_IC) << text;
    EXPECT_LT((X_IC->p - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12) << text;
    EXPECT_LT((X_IC->R * Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(-1, -2, 3)).norm(), 1e-12) << text;
  }
  // ORB-SLAM's is that of its first camera alone.
  std::ofstream(folder_ / "file") << OrbFile("Camera1",
                                             OrbFile("Camera2", "IMU.T_b_c1: " + imu_cam + "\n").substr(10));
  Mistakes none;
  EXPECT_TRUE(LoadPoseOnImu(folder_ / "file", none, "cam0"));
  EXPECT_FALSE(LoadPoseOnImu(folder_ / "file", none, "cam1"));
  EXPECT_THAT(none.Texts(), IsEmpty());
  std::ofstream(folder_ / "file") << kalibr << "T_cam_imu: [1, 2, 3]\n";
  Mistakes mistakes;
  EXPECT_FALSE(LoadPoseOnImu(folder_ / "file", mistakes));
  EXPECT_THAT(mistakes.Texts(), ElementsAre(HasSubstr("is no rigid motion")));
}

TEST_F(ForeignCalibration, WhatIsNoCalibrationIsRefusedInOneLine) {
  EXPECT_THAT(
      Read("imu0:\n  accelerometer_noise_density: 0.01\n  rate: 200\nmodel: adis\nother: 3\n").messages,
      ElementsAre(AllOf(HasSubstr("is not a camera"), HasSubstr("ORB-SLAM"))));
}

}  // namespace
}  // namespace kestrel::vision
