// SPDX-License-Identifier: Apache-2.0
#include "app/option/opencl_option.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "app/mosaic/mosaic_command.h"
#include "app/stabilise/stabilise_command.h"
#include "tests/support/temporary_folder.h"
#include "vision/enhance/motion/point_flow.h"

namespace kestrel::app {
namespace {

// Which device each row of a table names.
class OpenClOptionTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::filesystem::create_directory(folder_ / "images");
    cv::Mat fine(200, 260, CV_32FC1), scene;
    cv::RNG(3).fill(fine, cv::RNG::NORMAL, 0, 90);
    cv::GaussianBlur(fine, fine, {}, 2);
    fine.convertTo(scene, CV_8U, 3, 128);
    for (int i = 0; i < 4; ++i)
      cv::imwrite(fmt::format("{}/{}.png", (folder_ / "images").string(), i),
                  scene(cv::Rect(40 + 3 * i, 30, 160, 120)));
  }
  std::vector<std::string> Devices() const {
    std::ifstream csv(folder_ / "rows.csv");
    std::vector<std::string> devices;
    std::size_t column = 0;
    for (std::string line; std::getline(csv, line);) {
      std::vector<std::string> cells(1);
      for (const char c : line)
        c == ',' ? static_cast<void>(cells.emplace_back()) : cells.back().push_back(c);
      if (devices.empty()) {
        column = static_cast<std::size_t>(std::find(cells.begin(), cells.end(), "device") - cells.begin());
      }
      if (column >= cells.size()) return {};
      devices.push_back(cells[column]);
    }
    return devices;
  }
};

TEST_F(OpenClOptionTest, StabiliseAndMosaicTellWhatDevicePointsWereFollowedOn) {
  int rows = 0;
  for (const bool opencl : {false, true}) {
    StabiliseArguments stabilise;
    stabilise.input = (folder_ / "images").string(), stabilise.csv = (folder_ / "rows.csv").string();
    stabilise.options.mode = "reference", stabilise.quiet = true;
    stabilise.options.motion.opencl = opencl;
    StabiliseCommand(stabilise);
    const std::vector<std::string> stabilised = Devices();
    MosaicArguments mosaic;
    mosaic.input = stabilise.input, mosaic.csv = stabilise.csv, mosaic.out = (folder_ / "m.png").string();
    mosaic.quiet = true, mosaic.opencl = opencl;
    EXPECT_TRUE(MosaicCommand(mosaic));
    for (const auto& devices : {stabilised, Devices()}) {
      ASSERT_EQ(devices.size(), 5u);
      // The first image is compared with nothing, but is already there.
      for (std::size_t i = 1; i < devices.size(); ++i, ++rows)
        EXPECT_EQ(devices[i], vision::FlowDevice(opencl));
    }
    EXPECT_EQ(vision::FlowDevice(opencl) == "processor", !opencl);
  }
  EXPECT_EQ(rows, 16);
}

}  // namespace
}  // namespace kestrel::app
