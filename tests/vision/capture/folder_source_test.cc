// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/folder_source.h"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "base/stopwatch.h"
#include "tests/support/temporary_folder.h"
#include "vision/capture/camera_address.h"

namespace kestrel::vision {
namespace {

class FolderSourceTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    for (const char* stamp : {"1403636579763555584", "1403636579773555456", "1403636579793555584"})
      cv::imwrite(folder_ / (std::string(stamp) + ".png"), cv::Mat(24, 32, CV_8UC1, cv::Scalar(9)));
  }
};

TEST_F(FolderSourceTest, ImagesWithStampsComeAsTheyWereRecorded) {
  const auto address = ParseCameraAddress("file:" + folder_.string());
  ASSERT_TRUE(std::get<FolderSourceOptions>(address).as_recorded);
  const auto source = SourceAt(address)();
  ASSERT_TRUE(source->Open()) << source->Error();
  std::vector<double> stamps_s;
  while (const auto grabbed = source->Grab()) {
    stamps_s.push_back(*grabbed->stamp_s);
    EXPECT_GE(MonotonicNow_s(), stamps_s.back());
  }
  ASSERT_EQ(stamps_s.size(), 3u);
  // A double holds the monotonic clock of a year to 4 ns.
  EXPECT_NEAR(stamps_s[1] - stamps_s[0], 0.009999872, 1e-8);
  EXPECT_NEAR(stamps_s[2] - stamps_s[0], 0.03, 1e-8);
}

TEST_F(FolderSourceTest, ARateIsTakenInsteadOfTheStamps) {
  const auto address = ParseCameraAddress("file:" + folder_.string() + "?rate=1000");
  EXPECT_FALSE(std::get<FolderSourceOptions>(address).as_recorded);
  EXPECT_EQ(std::get<FolderSourceOptions>(address).rate_hz, 1000);
}

TEST_F(FolderSourceTest, WithoutStampsNothingComesAsRecorded) {
  std::filesystem::create_directory(folder_ / "numbers");
  cv::imwrite(folder_ / "numbers/1.png", cv::Mat(24, 32, CV_8UC1, cv::Scalar(9)));
  const auto source = FolderSource({.images = folder_ / "numbers", .size = {}, .as_recorded = true})();
  EXPECT_FALSE(source->Open());
  EXPECT_THAT(source->Error(), ::testing::HasSubstr("no stamps"));
}

}  // namespace
}  // namespace kestrel::vision
