// SPDX-License-Identifier: Apache-2.0
#include "records/video/video.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdio>
#include <opencv2/core.hpp>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace kestrel::records {
namespace {

namespace fs = std::filesystem;
using ::testing::Each;
using ::testing::Le;

constexpr int kFrames = 100;
constexpr double kRate_hz = 20;

class VideoTest : public InTemporaryFolder {
 protected:
  // Of noise, which no codec makes small.
  fs::path Written(std::optional<int> most_kbit_s) {
    const fs::path file = folder_ / "video.mp4";
    Video video(file, kRate_hz, most_kbit_s);
    cv::RNG random(1);
    cv::Mat frame(240, 320, CV_8UC3);
    for (int i = 0; i < kFrames; ++i) {
      random.fill(frame, cv::RNG::UNIFORM, 0, 256);
      video.Write(frame);
    }
    video.Close();
    return file;
  }
  // As ffmpeg's own reader has them: the numbers of the frames that stand by themselves, and one beyond the last.
  static std::vector<int> KeyFrames(const fs::path& file) {
    const std::string command = fmt::format(
        "ffprobe -v error -select_streams v -show_entries frame=key_frame -of csv=p=0 '{}'", file.string());
    std::FILE* pipe = popen(command.c_str(), "r");
    std::vector<int> keys;
    int is_key = 0, frame = 0;
    char rest[256];
    while (std::fscanf(pipe, "%d%255[^\n]", &is_key, rest) >= 1) {
      if (is_key) keys.push_back(frame);
      ++frame;
    }
    pclose(pipe);
    keys.push_back(frame);
    return keys;
  }
};

TEST_F(VideoTest, OfAPageIsFoundFrameByFrameAndIsNoLargerThanItMayBe) {
  const fs::path file = Written(400);
  const std::vector<int> keys = KeyFrames(file);
  EXPECT_EQ(keys.back(), kFrames);
  std::vector<int> between;
  for (std::size_t i = 1; i < keys.size(); ++i) between.push_back(keys[i] - keys[i - 1]);
  EXPECT_THAT(between, Each(Le(15)));
  // What may be sent beyond the rate is twice that of a second (bufsize).
  EXPECT_LT(static_cast<double>(fs::file_size(file)), 400e3 / 8 * (kFrames / kRate_hz + 2) * 1.1);
}

TEST_F(VideoTest, OfItsOwnIsAsLargeAsItNeeds) {
  const fs::path file = Written(std::nullopt);
  EXPECT_GT(static_cast<double>(fs::file_size(file)), 2e6);
}

}  // namespace
}  // namespace kestrel::records
