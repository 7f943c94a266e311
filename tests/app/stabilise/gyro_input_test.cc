// SPDX-License-Identifier: Apache-2.0
// The gyro of a recording: in the IMU's axes, by the recording's own clock.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "app/stabilise/stabilise_command.h"
#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kFirst_ns = 1403636579763555584;
constexpr int kImages = 6;

// A camera whose x is the IMU's y, whose y is its z, and whose z is its x.
class GyroInputTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    cv::Mat fine(120, 160, CV_32FC1), scene;
    cv::RNG(3).fill(fine, cv::RNG::NORMAL, 0, 90);
    cv::GaussianBlur(fine, fine, {}, 2);
    fine.convertTo(scene, CV_8U, 3, 128);
    const std::filesystem::path camera = folder_ / "mav0/cam0", imu = folder_ / "mav0/imu0";
    std::filesystem::create_directories(camera / "data");
    std::filesystem::create_directories(imu);
    std::ofstream images(camera / "data.csv"), rates(imu / "data.csv"), in_camera(folder_ / "gyro.csv");
    for (int i = 0; i < kImages; ++i) {
      const std::int64_t stamp = kFirst_ns + i * 50'000'000LL;
      cv::imwrite(camera / "data" / fmt::format("{}.png", stamp), scene);
      images << stamp << ',' << stamp << ".png\n";
    }
    std::ofstream(camera / "sensor.yaml")
        << "T_BS:\n  cols: 4\n  rows: 4\n  data: [0, 0, 1, 0.1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1]\n"
           "resolution: [160, 120]\ncamera_model: pinhole\nintrinsics: [150, 150, 79.5, 59.5]\n"
           "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";
    rates << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1]\n";
    in_camera << "t_s,wx_rad_s,wy_rad_s,wz_rad_s\n";
    for (int i = -10; i < 60; ++i) {  // from before the first image until after the last
      const double x = 0.02 * (i % 7), y = 0.03 * (i % 5), z = -0.02 * (i % 3);
      rates << kFirst_ns + i * 5'000'000LL << fmt::format(",{},{},{},0,0,9.8\n", x, y, z);
      in_camera << fmt::format("{},{},{},{}\n", 0.005 * i, y, z, x);
    }
    arguments_.input = folder_.string();
    arguments_.csv = (folder_ / "path.csv").string();
    arguments_.options.mode = "reference";
    arguments_.options.by = "gyro";
    arguments_.quiet = true;
  }
  // The rows of the table, up to what a clock measured.
  std::vector<std::string> Rows() {
    StabiliseCommand(arguments_);
    std::vector<std::string> rows;
    std::ifstream csv(arguments_.csv);
    for (std::string line; std::getline(csv, line);) {
      std::size_t end = 0;
      for (int commas = 0; commas < 11; ++commas) end = line.find(',', end + 1);
      rows.push_back(line.substr(0, end));
    }
    return rows;
  }
  StabiliseArguments arguments_;
};

TEST_F(GyroInputTest, EurocsOwnGyroIsTakenInTheCamerasAxesAndOfTheImagesClock) {
  const std::vector<std::string> own = Rows();
  ASSERT_EQ(own.size(), kImages + 1u);
  EXPECT_THAT(own[2], ::testing::StartsWith("1,0.050000000,gyro,"));
  arguments_.imu = (folder_ / "gyro.csv").string();
  arguments_.imu_offset_s = 0;
  EXPECT_EQ(Rows(), own);
}

TEST_F(GyroInputTest, WithoutTheCamerasPoseOnTheImuItIsAskedFor) {
  std::ofstream(folder_ / "camera.yaml") << "width_px: 160\nheight_px: 120\nfx_px: 150\nfy_px: 150\n"
                                            "cx_px: 79.5\ncy_px: 59.5\n";
  arguments_.camera = (folder_ / "camera.yaml").string();
  try {
    StabiliseCommand(arguments_);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("T_cam_imu of Kalibr"));
  }
}

}  // namespace
}  // namespace kestrel::app
