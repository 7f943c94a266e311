// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/images/event_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <tuple>

#include "flight/simulated/runner.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using Files = InTemporaryFolder;

TEST_F(Files, EventsAreLinesOfTimePlaceAndSign) {
  EventFiles files(folder_ / "events");
  files.Write({{7, 3, 2, true}, {1'020'000'300, 640, 0, false}});
  files.Write({{12'000'000'000, 0, 1, true}});
  files.Close();
  EXPECT_EQ(Content(folder_ / "events/events.txt"),
            "0.000000007 3 2 1\n1.020000300 640 0 0\n12.000000000 0 1 1\n");
}

TEST_F(Files, AViewShowsTheEventsOfItsLastTenMilliseconds) {
  EventFiles files(folder_);
  const cv::Mat1b frame(2, 4, 100);
  files.Write({{89'000'000, 0, 0, true},     // too early for the view at 0.1 s
               {91'000'000, 1, 0, true},     // brighter
               {95'000'000, 2, 1, true},     // and then darker
               {96'000'000, 2, 1, false},    //
               {101'000'000, 3, 0, true}});  // too late, but not for the next
  files.WriteView(4, 0.1, frame);
  files.WriteView(5, 0.105, frame);
  const cv::Vec3b grey(100, 100, 100), red(0, 0, 255), blue(255, 0, 0);
  const cv::Mat3b first = cv::imread(folder_ / "000004_events.png"),
                  next = cv::imread(folder_ / "000005_events.png");
  ASSERT_EQ(first.size(), frame.size());
  EXPECT_EQ(first(0, 0), grey);
  EXPECT_EQ(first(0, 1), red);
  EXPECT_EQ(first(1, 2), blue);
  EXPECT_EQ(first(0, 3), grey);
  EXPECT_EQ(next(0, 1), grey);
  EXPECT_EQ(next(1, 2), blue);
  EXPECT_EQ(next(0, 3), red);
}

TEST_F(Files, WhatAnEarlierRunLeftIsRemoved) {
  std::ofstream(folder_ / "000017_events.png") << "old";
  std::ofstream(folder_ / "mine.png") << "mine";
  EventFiles files(folder_);
  EXPECT_FALSE(fs::exists(folder_ / "000017_events.png"));
  EXPECT_TRUE(fs::exists(folder_ / "mine.png"));
}

// The flight is the same with events and without, and they are in their order and within the image.
TEST_F(Files, AFlightIsTheSameWithItsEvents) {
  const LoadedScenario loaded = LoadScenario("landing", {"duration_s=0.3", "start.settle_s=1", "seed=101",
                                                         "camera=thesis_6mm_binned", "criteria={}"});
  const FlightResult without = RunFlight(loaded, {});
  RunOptions options;
  options.folder = folder_ / "run", options.video = false, options.events = true;
  const FlightResult with = RunFlight(loaded, options);
  EXPECT_EQ(with.summary.error, "");
  EXPECT_EQ(with.summary.state_hash, without.summary.state_hash);
  EXPECT_EQ(with.summary.image_hash, without.summary.image_hash);
  EXPECT_TRUE(fs::exists(folder_ / "run/events/000000_events.png"));
  std::ifstream lines(folder_ / "run/events/events.txt");
  double t_s = 0, last_s = 0;
  int x = 0, y = 0, on = 0, count = 0;
  std::set<int> signs;
  for (std::tuple<double, int, int> last; lines >> t_s >> x >> y >> on;
       last = {t_s, y, x}, last_s = t_s, ++count) {
    ASSERT_LE(last, std::tuple(t_s, y, x));
    ASSERT_LT(x, vision::WidthPx(loaded.simulator.camera));
    ASSERT_LT(y, vision::HeightPx(loaded.simulator.camera));
    signs.insert(on);
  }
  EXPECT_GT(count, 100);
  EXPECT_EQ(signs, (std::set<int>{0, 1}));
  EXPECT_NEAR(last_s, 0.3, 0.1);
}

}  // namespace
}  // namespace kestrel::flight
