// SPDX-License-Identifier: Apache-2.0
#include "mission/caption/strip.h"

#include <gtest/gtest.h>

namespace kestrel::mission {
namespace {

// As much as a flight that follows a balloon says.
StripText Much() {
  return {"  12.35 s",
          "LIVE, SIMULATED AIRCRAFT",
          {{"look around"},
           {"balloon lost", true},
           {"u +123.4 (+0)  v -101.2 (+0)  diameter 52.1 (47) px  12.34 m"},
           {"ahead -1.25  down +0.50 m/s  yaw -45.0 deg/s"}}};
}

void LiesWithin(const StripText& text, int width_px, int rows) {
  const cv::Rect strip(0, 0, width_px, rows * kStripRow_px + 4);
  const std::vector<PlacedText> placed = PlacedInStrip(text, width_px, rows);
  std::size_t wanted = text.captions.size();
  for (const std::string* each : {&text.left, &text.right}) wanted += !each->empty();
  ASSERT_EQ(placed.size(), wanted) << "something is not said";
  for (std::size_t i = 0; i < placed.size(); ++i) {
    EXPECT_EQ(placed[i].box & strip, placed[i].box) << placed[i].text;
    for (std::size_t k = i + 1; k < placed.size(); ++k)
      EXPECT_EQ((placed[i].box & placed[k].box).area(), 0) << placed[i].text << ", " << placed[k].text;
  }
}

TEST(StripTest, WordsNeitherCoverEachOtherNorLeaveTheStrip) {
  for (const int width_px : {1280, 640, 320, 160}) LiesWithin(Much(), width_px, 3);
  LiesWithin(Much(), 640, 1);
  LiesWithin({"  12.35 s", "SIMULATOR", {}}, 640, 1);
  LiesWithin({{}, {}, {{"lost"}}}, 320, 1);
}

TEST(StripTest, IsLegibleWhereThereIsRoom) {
  for (const PlacedText& each : PlacedInStrip(Much(), 640, 3)) EXPECT_GE(each.scale, 0.4) << each.text;
}

TEST(StripTest, TheImageStaysAsItIsAndTheHeightIsTheSameWhateverIsSaid) {
  const cv::Mat image(48, 320, CV_8UC3, cv::Scalar(10, 200, 30));
  const cv::Mat drawn = WithStrip(image, Much(), 3), silent = WithStrip(image, {}, 3);
  EXPECT_EQ(drawn.size(), silent.size());
  EXPECT_EQ(cv::norm(drawn.rowRange(0, 48), image, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(drawn.rowRange(48, drawn.rows), silent.rowRange(48, drawn.rows), cv::NORM_INF), 200);
}

}  // namespace
}  // namespace kestrel::mission
