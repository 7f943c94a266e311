// SPDX-License-Identifier: Apache-2.0
#include "app/flight/replay_command.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/user_file.h"
#include "flight/simulated/runner.h"
#include "records/summary.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

class ReplayCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    flight::RunOptions options;
    options.folder = folder_;
    options.video = false;
    options.images = true;
    flight::RunFlight(
        flight::LoadScenario("hover", {"duration_s=1.5", "start.settle_s=1", "pilot.servo.lambda_per_s=1.1"}),
        options);
  }
  bool Replay(const std::vector<std::string>& overrides = {}, double tolerance = 0) const {
    ReplayArguments arguments;
    arguments.folder = folder_.string();
    arguments.overrides = overrides, arguments.tolerance = tolerance, arguments.quiet = true;
    return ReplayCommand(arguments);
  }
};

TEST_F(ReplayCommandTest, TheSameCodeSaysTheSameToTheLastBit) { EXPECT_TRUE(Replay()); }

TEST_F(ReplayCommandTest, WhatTheMissionMakesOfItNowHasRecordsAndAPage) {
  ReplayArguments arguments;
  arguments.folder = folder_.string();
  arguments.quiet = true;
  arguments.out = (folder_ / "again").string();
  ASSERT_TRUE(ReplayCommand(arguments));
  const records::Summary summary = records::ReadSummary(folder_ / "again" / "summary.json");
  EXPECT_EQ(summary.mode, "RECORDING");
  EXPECT_TRUE(summary.passed);
  for (const char* file : {"telemetry.csv", "events.log", "video.mp4", "report.html"})
    EXPECT_TRUE(IsFile(folder_ / "again" / file)) << file;
  arguments.out = arguments.folder;  // which would be overwritten
  EXPECT_THROW(ReplayCommand(arguments), InputError);
  EXPECT_FALSE(IsFile(folder_ / "report.html"));
}

TEST_F(ReplayCommandTest, AnotherGainIsSeenToAskForAnotherVelocity) {
  EXPECT_FALSE(Replay({"pilot.servo.lambda_per_s=0.8"}));
}

TEST_F(ReplayCommandTest, WhatDiffersWithinTheToleranceIsEqual) {
  EXPECT_FALSE(Replay({"pilot.servo.lambda_per_s=1.1000001"}));
  EXPECT_TRUE(Replay({"pilot.servo.lambda_per_s=1.1000001"}, 1e-3));
}

TEST_F(ReplayCommandTest, AMissingImageAndOneThatIsCutOffAreRefusedBeforeTheReplayBegins) {
  const auto refused = [&] {
    try {
      Replay();
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("not refused");
  };
  const auto image = [&](int i) { return folder_ / fmt::format("recording/{:06d}.png", i); };
  ASSERT_TRUE(std::filesystem::exists(image(3)));
  std::filesystem::resize_file(image(3), std::filesystem::file_size(image(3)) / 2);
  EXPECT_THAT(refused(), ::testing::HasSubstr("1 of "));
  EXPECT_THAT(refused(), ::testing::HasSubstr("000003.png"));
  std::filesystem::remove(image(5));
  EXPECT_THAT(refused(), ::testing::HasSubstr("2 of "));
}

TEST_F(ReplayCommandTest, AFlightByACameraOnTheGroundIsRefusedAsItsImagesAreNotRecorded) {
  WriteFile(folder_ / "scenario.yaml", "mission: hover_ground_camera\nground_camera: {camera: ground_6mm}\n");
  EXPECT_THAT([&] { Replay(); }, ::testing::Throws<InputError>(::testing::Property(
                                     &InputError::what, ::testing::HasSubstr("camera on the ground"))));
}

TEST_F(ReplayCommandTest, AToleranceThatIsNoneIsRefused) {
  EXPECT_THROW(Replay({}, -1), InputError);
  EXPECT_THROW(Replay({}, std::numeric_limits<double>::quiet_NaN()), InputError);
}

}  // namespace
}  // namespace kestrel::app
