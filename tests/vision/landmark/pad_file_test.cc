// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::vision {
namespace {

class PadFileTest : public InTemporaryFolder {
 protected:
  // A pad of a dark square on white.
  PadReference Pad(int square_px, const char* size_m) {
    cv::Mat picture(256, 256, CV_8U, cv::Scalar(255));
    cv::rectangle(picture, cv::Rect(64, 64, square_px, square_px), cv::Scalar(0), cv::FILLED);
    cv::imwrite((folder_ / "pad.png").string(), picture);
    std::ofstream(folder_ / "pad.yaml") << "texture: pad.png\nsize_m: " << size_m << "\n";
    Mistakes mistakes;
    const PadFile pad = LoadPad(folder_ / "pad.yaml", mistakes);
    mistakes.ThrowIfAny();
    return pad.reference;
  }
};

TEST_F(PadFileTest, ReadAgainItIsWhatTheFilesNowHold) {
  const PadReference first = Pad(100, "[1, 1]"), same = Pad(100, "[1, 1]");
  ASSERT_FALSE(first.levels.empty());
  ASSERT_FALSE(first.levels[0].corners.empty());
  EXPECT_EQ(same.levels[0].corners, first.levels[0].corners);
  EXPECT_NE(Pad(60, "[1, 1]").levels[0].corners, first.levels[0].corners);  // another picture, under its name
  const PadReference larger = Pad(60, "[2, 1]");
  EXPECT_EQ(larger.length_m, 2);
  EXPECT_EQ(Pad(60, "[1, 1]").length_m, 1);
}

}  // namespace
}  // namespace kestrel::vision
