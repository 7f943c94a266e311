// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/control_monitor.h"

#include <gtest/gtest.h>

namespace kestrel::flight {
namespace {

const control::SafetyChange kFly{0, control::Hazard::kNone, control::Reaction::kFly, false};
const control::SafetyChange kLimited{0, control::Hazard::kNone, control::Reaction::kFly, true};
const control::SafetyChange kNothing{0, control::Hazard::kNoSetpoint, control::Reaction::kHold, false};
const control::SafetyChange kHold{0, control::Hazard::kImageStale, control::Reaction::kHold, false};
const control::SafetyChange kSink{0, control::Hazard::kImageStale, control::Reaction::kSink, false};
const control::SafetyChange kPilot{0, control::Hazard::kPilot, control::Reaction::kSilence, false};
const control::SafetyChange kNoLink{0, control::Hazard::kStateLost, control::Reaction::kSilence, false};

class ControlWatchTest : public ::testing::Test {
 protected:
  // For a second each.
  void InAir(const control::SafetyChange& safety) { Note(safety, false); }
  void Landed(const control::SafetyChange& safety) { Note(safety, true); }
  void Note(const control::SafetyChange& safety, bool landed) {
    control::VehicleState state;
    state.landed = landed;
    for (int i = 0; i < 20; ++i, t_s_ += 0.05) watch_.Note(t_s_, safety, state);
  }
  // Of a mission that has done what it is for.
  void Expect(const char* outcome, bool passes, const char* by_mission = "") const {
    const auto verdict = watch_.Judge(by_mission, *by_mission ? "" : "time is up", true);
    EXPECT_EQ(verdict.outcome, outcome);
    EXPECT_EQ(verdict.accomplished, passes);
  }

  double t_s_ = 0;
  ControlMonitor watch_;
};

TEST_F(ControlWatchTest, ALandingOfTheMissionPasses) {
  InAir(kFly);
  InAir(kLimited);
  Landed(kFly);
  Landed(kNothing);
  Expect("landed", true, "landed");
}

TEST_F(ControlWatchTest, WhatComesAfterTheLandingIsOfNoMatter) {
  InAir(kFly);
  Landed(kFly);
  Landed(kPilot);  // an autopilot that leaves the mode with the motors stopped
  Expect("landed", true, "landed");
}

TEST_F(ControlWatchTest, AMissionThatAsksForNothingInFlightHasTheAircraftStill) {
  InAir(kNothing);
  Expect("time is up", true);
}

TEST_F(ControlWatchTest, ALandingByTheSafetyLayerDoesNotPass) {
  InAir(kFly);
  InAir(kSink);
  Landed(kSink);
  Expect("landed by the safety layer: image stale", false, "landed");
}

TEST_F(ControlWatchTest, NorIfTheImagesAreBackBeforeTheTouchDownIsTold) {
  InAir(kFly);
  InAir(kSink);
  Landed(kFly);
  Expect("landed by the safety layer: image stale", false, "landed");
}

TEST_F(ControlWatchTest, AMissionThatTookOverAgainAfterSinkingLandsItself) {
  InAir(kSink);
  InAir(kFly);
  InAir(kFly);
  InAir(kFly);
  Landed(kFly);
  Expect("landed", true, "landed");
}

TEST_F(ControlWatchTest, ThePilotsLandingIsHis) {
  InAir(kFly);
  InAir(kPilot);
  Landed(kPilot);
  Expect("landed by the pilot", false, "landed");
}

TEST_F(ControlWatchTest, WhoHasTheAircraftAtTheEndIsNamed) {
  InAir(kFly);
  InAir(kNoLink);
  Expect("ended without link", false);
  InAir(kPilot);
  Expect("ended by the pilot", false);
  InAir(kHold);
  Expect("ended by the safety layer: image stale", false);
  Expect("ended by the safety layer: image stale", false, "goal reached");
}

TEST_F(ControlWatchTest, AFlightByTimeIsTheMissionsAllAlong) {
  InAir(kFly);
  InAir(kHold);  // for a moment: the mission goes on
  InAir(kFly);
  Expect("time is up", true);
  InAir(kPilot);
  InAir(kFly);
  Expect("time is up, meanwhile flown by the pilot", false);
}

TEST_F(ControlWatchTest, WhatNeverLeftTheGroundHasNotFlown) {
  Landed(kFly);
  Expect("never left the ground", false, "landed");
}

TEST_F(ControlWatchTest, AnEndFromOutsideIsNoneOfTheMissions) {
  InAir(kFly);
  const auto verdict = watch_.Judge("", "interrupted", true);
  EXPECT_EQ(verdict.outcome, "interrupted");
  EXPECT_FALSE(verdict.accomplished);
}

TEST_F(ControlWatchTest, AMissionThatSaysItFailedIsTakenAtItsWord) {
  InAir(kHold);
  const auto verdict = watch_.Judge("pad not found", "", false);
  EXPECT_EQ(verdict.outcome, "pad not found");
  EXPECT_FALSE(verdict.accomplished);
}

}  // namespace
}  // namespace kestrel::flight
