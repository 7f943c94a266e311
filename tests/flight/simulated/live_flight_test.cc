// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <string>
#include <vector>

#include "flight/simulated/runner.h"
#include "tests/support/content.h"
#include "tests/support/live_client.h"
#include "tests/support/temporary_folder.h"

// Flights in the simulator with viewers, who come by the wire as any other program.
namespace kestrel::flight {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

std::uint16_t PortOf(const Live& live) {
  const std::string url = live.url();
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
}

LiveOptions AsFastAsItGoes() {
  LiveOptions options;
  options.server.port = 0;
  options.speed = 0;
  options.await_viewer = true;
  return options;
}

LoadedScenario Hover(const std::string& changeable) {
  return LoadScenario("hover", {"duration_s=1.2", "start.settle_s=1", "seed=5", "changeable=" + changeable});
}

class LiveFlightInTheSimulator : public InTemporaryFolder {
 protected:
  // Of a thread of its own, so that the test is the viewer.
  std::future<records::Summary> Fly(const LoadedScenario& loaded) {
    options_.folder = folder_;
    options_.video = false;
    options_.live = &live_;
    options_.progress = [this](const records::LogRow&) { return !stop_.load(); };
    return std::async(std::launch::async, [&] { return RunFlight(loaded, options_).summary; });
  }

  Live live_{AsFastAsItGoes()};
  RunOptions options_;
  std::atomic<bool> stop_ = false;
};

TEST_F(LiveFlightInTheSimulator, IsTheSameToTheLastBitWhateverAViewerDoesWithItsTime) {
  const LoadedScenario loaded = Hover("[]");
  const records::Summary alone = RunFlight(loaded, {}).summary;
  auto flown = Fly(loaded);
  LiveClient viewer(PortOf(live_));
  ASSERT_TRUE(viewer.Join("/live"));
  EXPECT_EQ(viewer.HearOp("flight")["scenario"], "hover");
  viewer.Say(R"({"op":"pause"})");
  while (viewer.HearOp("state")["paused"] != true) continue;
  viewer.Say(R"({"op":"step"})");
  viewer.Say(R"({"op":"resume"})");
  const json end = viewer.HearOp("end");
  EXPECT_EQ(end["outcome"], "completed");
  const records::Summary watched = flown.get();
  EXPECT_EQ(watched.state_hash, alone.state_hash);
  EXPECT_EQ(watched.image_hash, alone.image_hash);
}

TEST_F(LiveFlightInTheSimulator, HasEachRowAndEventOfItsFolder) {
  const LoadedScenario loaded = Hover("[]");
  auto flown = Fly(loaded);
  LiveClient viewer(PortOf(live_));
  ASSERT_TRUE(viewer.Join("/live"));
  std::size_t rows = 0;
  std::vector<std::string> events;
  for (;;) {
    const std::string text = viewer.Hear();
    if (viewer.binary()) continue;
    const json message = json::parse(text);
    if (message["op"] == "rows") rows += message["rows"].size();
    if (message["op"] == "event") events.push_back(message["what"]);
    if (message["op"] == "end") break;
  }
  flown.get();
  const std::string telemetry = Content(folder_ / "telemetry.csv"), log = Content(folder_ / "events.log");
  EXPECT_EQ(rows + 1, static_cast<std::size_t>(std::ranges::count(telemetry, '\n')));
  // But for the first line, which is there before the flight.
  EXPECT_EQ(events.size() + 1, static_cast<std::size_t>(std::ranges::count(log, '\n')));
  EXPECT_GT(rows, 10u);
}

TEST_F(LiveFlightInTheSimulator, IsChangedWhereItsScenarioSaysSoAndFlownAgainFromItsFile) {
  const LoadedScenario loaded = Hover("[{key: wind.mean_m_s, max: 6}]");
  auto flown = Fly(loaded);
  LiveClient viewer(PortOf(live_));
  ASSERT_TRUE(viewer.Join("/live"));
  viewer.Say(R"({"op":"pause"})");
  viewer.Say(R"({"op":"change","key":"wind.mean_m_s","value":7})");
  EXPECT_THAT(viewer.HearOp("refused")["why"].get<std::string>(), HasSubstr("6"));
  viewer.Say(R"({"op":"change","key":"pilot.servo.lambda_per_s","value":1})");
  EXPECT_THAT(viewer.HearOp("refused")["why"].get<std::string>(), HasSubstr("pilot.servo.lambda_per_s"));
  viewer.Say(R"({"op":"change","key":"wind.mean_m_s","value":5.5})");
  const json changed_to = viewer.HearOp("changed");
  EXPECT_EQ(changed_to["value"], 5.5);
  EXPECT_THAT(changed_to["again"].get<std::string>(), HasSubstr((folder_ / "scenario.yaml").string()));
  viewer.Say(R"({"op":"resume"})");
  const records::Summary changed = flown.get();
  EXPECT_THAT(Content(folder_ / "events.log"), HasSubstr("change: wind.mean_m_s"));
  EXPECT_THAT(Content(folder_ / "page.json"),
              HasSubstr("kestrel run " + (folder_ / "scenario.yaml").string()));
  EXPECT_NE(changed.state_hash, RunFlight(loaded, {}).summary.state_hash);
  EXPECT_EQ(RunFlight(LoadScenario(folder_ / "scenario.yaml"), {}).summary.state_hash, changed.state_hash);
}

TEST_F(LiveFlightInTheSimulator, EndsInGoodOrderWhileItIsPaused) {
  const LoadedScenario loaded = Hover("[]");
  auto flown = Fly(loaded);
  LiveClient viewer(PortOf(live_));
  ASSERT_TRUE(viewer.Join("/live"));
  viewer.Say(R"({"op":"pause"})");
  while (viewer.HearOp("state")["paused"] != true) continue;
  stop_ = true;
  EXPECT_EQ(flown.get().outcome, "interrupted");
}

}  // namespace
}  // namespace kestrel::flight
