// SPDX-License-Identifier: Apache-2.0
// sensor.yaml as the EuRoC data set has it, against cv::projectPoints.
#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/calib3d.hpp>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kBegin =
    "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor cam0 (MT9M034)\n\nT_BS:\n  cols: "
    "4\n"
    "  rows: 4\n  data: [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,\n"
    "         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,\n"
    "        -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,\n"
    "         0.0, 0.0, 0.0, 1.0]\n\nrate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\n"
    "intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv\n";

class EurocCalibration : public InTemporaryFolder {
 protected:
  std::filesystem::path Write(const std::string& end) const {
    std::ofstream(folder_ / "sensor.yaml") << kBegin << end;
    return folder_ / "sensor.yaml";
  }
};

TEST_F(EurocCalibration, ProjectsAsOpenCvDoesAndSaysWhereTheCameraIsOnTheImu) {
  const auto file = Write(
      "distortion_model: radial-tangential\n"
      "distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n");
  Mistakes mistakes;
  const CameraModel camera = LoadCamera(file, mistakes);
  ASSERT_TRUE(mistakes.empty()) << InputError(mistakes.all()).what();
  EXPECT_EQ(WidthPx(camera), 752);
  EXPECT_EQ(HeightPx(camera), 480);
  const std::vector<cv::Vec3d> points = {{0, 0, 1}, {0.3, -0.2, 1}, {-0.5, 0.3, 1.1}, {0.6, 0.4, 1}};
  std::vector<cv::Vec2d> oracle;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(),
                    cv::Matx33d(458.654, 0, 367.215, 0, 457.296, 248.375, 0, 0, 1),
                    std::vector<double>{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}, oracle);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = Project(camera, {points[i][0], points[i][1], points[i][2]});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), oracle[i][0], 1e-9);
    EXPECT_NEAR(pixel->y(), oracle[i][1], 1e-9);
  }
  const auto X_IC = LoadPoseOnImu(file, mistakes);
  ASSERT_TRUE(X_IC);
  EXPECT_NEAR((X_IC->R * Eigen::Vector3d::UnitZ()).x(), 0.00414029679422, 1e-9);
  EXPECT_EQ(X_IC->p, Eigen::Vector3d(-0.0216401454975, -0.064676986768, 0.00981073058949));
}

TEST_F(EurocCalibration, AFisheyeOfTumViAndAModelThatIsNone) {
  Mistakes mistakes;
  const CameraModel fisheye = LoadCamera(
      Write("distortion_model: equidistant\ndistortion_coefficients: [0.0034, 0.0007, -0.002, 0.0002]\n"),
      mistakes);
  EXPECT_TRUE(mistakes.empty());
  EXPECT_STREQ(NameOf(fisheye), "kannala_brandt");
  LoadCamera(Write("distortion_model: wavy\ndistortion_coefficients: [0, 0, 0, 0]\n"), mistakes);
  EXPECT_THAT(InputError(mistakes.all()).what(), AllOf(HasSubstr("'wavy'"), HasSubstr("radial-tangential")));
}

}  // namespace
}  // namespace kestrel::vision
