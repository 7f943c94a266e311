// SPDX-License-Identifier: Apache-2.0
// Flights whose vision makes something for people to look at: shorter than the scenarios, judged by the truth.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "records/video/video_reader.h"
#include "tests/acceptance/flown.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

// A part of a turn closes nothing.
const std::string kNoClosure = "criteria={panorama_rms_deg: {max: 0.1}}";

double Metric(const flight::FlightResult& result, const char* name) {
  return result.summary.metrics.at(name);
}

TEST(Stabilise, WhatIsSeenAtTheCornersShakesLess) {
  const auto result = Flown("stabilise", 101, {"flight.hover_s=3", "flight.transit_m=4"});
  EXPECT_EQ(result.summary.outcome, "flown");
  EXPECT_EQ(Metric(result, "stabilised_share"), 1);
  EXPECT_GT(Metric(result, "jitter_in_px"), 1);
  EXPECT_LT(Metric(result, "jitter_left"), 0.1);
  EXPECT_LT(Metric(result, "stabilised_late_s"), 2.2);
}

// The vision of this flight moves nothing: a camera that shakes flies the same way.
TEST(Stabilise, TheMountShakesTheCameraAndNotTheFlight) {
  const std::vector<std::string> moment = {"duration_s=2", "start.settle_s=1"};
  std::vector<std::string> still = moment;
  still.push_back("mount.vibration=[]");
  const auto shaken = Flown("stabilise", 101, moment), calm = Flown("stabilise", 101, still);
  EXPECT_EQ(shaken.summary.state_hash, calm.summary.state_hash);
  EXPECT_NE(shaken.summary.image_hash, calm.summary.image_hash);
}

TEST(Survey, TheMosaicOfTwoLinesIsTrue) {
  const auto result =
      Flown("survey", 101,
            {"flight.lines=2", "flight.line_m=24", "flight.spacing_m=30", "flight.images=50",
             "flight.begin_m=[-10, -15]", "start.offset_m=[-10, -15]", "flight.mosaic.chain=false"});
  EXPECT_EQ(result.summary.outcome, "surveyed");
  EXPECT_EQ(Metric(result, "mosaic_images"), 50);
  EXPECT_EQ(Metric(result, "mosaic_share"), 1);
  EXPECT_LT(Metric(result, "mosaic_rms_px"), 1);
  EXPECT_LT(Metric(result, "mosaic_closure_px"), 1);
  EXPECT_LT(Metric(result, "path_horizontal_rmse_m"), 8);
}

TEST(Panorama, APartOfATurnIsTrue) {
  const auto result = Flown("panorama", 101, {"flight.turn_deg=50", "flight.images=50", kNoClosure});
  EXPECT_EQ(result.summary.outcome, "turned");
  EXPECT_EQ(Metric(result, "mosaic_images"), 50);
  EXPECT_EQ(Metric(result, "mosaic_share"), 1);
  EXPECT_LT(Metric(result, "panorama_rms_deg"), 0.1);
  EXPECT_FALSE(result.summary.metrics.count("panorama_closure_deg"));
}

class Products : public InTemporaryFolder {};

TEST_F(Products, AreInTheFolderWhenTheyAreComplete) {
  const auto loaded = flight::LoadScenario("panorama", {"seed=101", "flight.turn_deg=15", "flight.images=12",
                                                        "flight.mosaic.chain=false", kNoClosure});
  flight::RunOptions options;
  options.folder = folder_;
  const flight::FlightResult result = flight::RunFlight(loaded, options);
  EXPECT_EQ(result.summary.error, "");
  EXPECT_FALSE(cv::imread((folder_ / "mosaic.png").string()).empty());
  EXPECT_FALSE(cv::imread((folder_ / "mosaic_growth.png").string()).empty());
  for (const char* plot : {"path.png", "growth.png"})
    EXPECT_FALSE(cv::imread((folder_ / "plots" / plot).string()).empty()) << plot;
  records::VideoReader video(folder_ / "mosaic.mp4");
  EXPECT_EQ(video.size(), cv::Size(960, 720));
  for (const auto& each : std::filesystem::recursive_directory_iterator(folder_))
    EXPECT_NE(each.path().extension(), ".part") << each.path();
}

// On the ground it takes off first.
TEST(Panorama, TakesOffFromTheGround) {
  const auto result =
      Flown("panorama", 101,
            {"flight.turn_deg=20", "flight.images=10", "flight.height_m=6", "flight.mosaic.chain=false",
             "start={height_m: 0.3, on_ground: true}", kNoClosure});
  EXPECT_EQ(result.summary.outcome, "turned");
  EXPECT_EQ(result.rows.front().decision.phase, "take off");
  EXPECT_NEAR(result.rows.back().now.X_NB.p.z(), -6, 1.5);
  EXPECT_EQ(Metric(result, "mosaic_images"), 10);
}

}  // namespace
}  // namespace kestrel
