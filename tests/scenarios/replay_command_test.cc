// SPDX-License-Identifier: Apache-2.0
#include "scenarios/replay_command.h"

#include <gtest/gtest.h>

#include "scenarios/runner.h"
#include "tests/scenarios/temporary_folder.h"

namespace kestrel {
namespace {

class ReplayCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    RunOptions options;
    options.folder = folder_;
    options.video = false;
    options.images = true;
    RunFlight(LoadScenario("hover", {"duration_s=1.5", "start.settle_s=1"}), options);
  }
  bool Replay(const std::vector<std::string>& overrides = {}, double tolerance = 0) const {
    return ReplayCommand({folder_.string(), "", overrides, tolerance, true});
  }
};

TEST_F(ReplayCommandTest, TheSameCodeSaysTheSameToTheLastBit) { EXPECT_TRUE(Replay()); }

TEST_F(ReplayCommandTest, AnotherGainIsSeenToAskForAnotherVelocity) {
  EXPECT_FALSE(Replay({"pilot.servo.lambda_per_s=0.8"}));
}

TEST_F(ReplayCommandTest, WhatDiffersWithinTheToleranceIsEqual) {
  EXPECT_FALSE(Replay({"pilot.servo.lambda_per_s=1.1000001"}));
  EXPECT_TRUE(Replay({"pilot.servo.lambda_per_s=1.1000001"}, 1e-3));
}

}  // namespace
}  // namespace kestrel
