// SPDX-License-Identifier: Apache-2.0
#include "control/link/safe_autopilot.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <thread>

#include "base/stopwatch.h"
#include "tests/control/link/fake_link.h"

namespace kestrel::control {
namespace {

constexpr double kDeadline_s = 20;

bool Eventually(const std::function<bool()>& condition) {
  const double until_s = MonotonicNow_s() + kDeadline_s;
  while (!condition()) {
    if (MonotonicNow_s() > until_s) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

class SafeAutopilotTest : public testing::Test {
 protected:
  std::unique_ptr<SafeAutopilot> Make(const SafeAutopilot::Options& options = {}) {
    return std::make_unique<SafeAutopilot>(
        link_,
        [this]() -> std::optional<double> {
          const double age_s = image_age_s_;
          return age_s < 0 ? std::nullopt : std::optional(age_s);
        },
        options);
  }
  bool Holds() const {
    const auto v = link_.velocity();
    return v && v->isZero();
  }
  static SafeAutopilot::Options Slow() {
    SafeAutopilot::Options options;
    options.limits.speed_m_s = 0.5;
    return options;
  }
  static Setpoint Ahead() { return VelocitySetpoint{{1, 0, 0}, 0}; }

  FakeLink link_;
  std::atomic<double> image_age_s_ = 0;
};

TEST_F(SafeAutopilotTest, WhatIsAskedForIsSentAtOnce) {
  const auto safe = Make();
  safe->Send(Ahead());
  ASSERT_TRUE(link_.velocity());
  EXPECT_EQ(*link_.velocity(), Eigen::Vector3d(1, 0, 0));
}

TEST_F(SafeAutopilotTest, MoreThanIsAllowedIsLimited) {
  const auto safe = Make(Slow());
  safe->Send(Ahead());
  EXPECT_EQ(*link_.velocity(), Eigen::Vector3d(0.5, 0, 0));
}

TEST_F(SafeAutopilotTest, FlightCodeThatHangsIsHeldByTheThread) {
  const auto safe = Make();
  safe->Send(Ahead());
  EXPECT_TRUE(Eventually([&] { return Holds(); }));  // once the setpoint is older than an image may be
}

TEST_F(SafeAutopilotTest, AStaleImageIsHeldThoughFlightCodeGoesOnAsking) {
  const auto safe = Make();
  image_age_s_ = 0.6;
  safe->Send(Ahead());
  EXPECT_TRUE(Holds());
  image_age_s_ = 0.1;
  safe->Send(Ahead());
  EXPECT_FALSE(Holds());
}

TEST_F(SafeAutopilotTest, NoImageYetIsHeld) {
  image_age_s_ = -1;
  const auto safe = Make();
  safe->Send(Ahead());
  EXPECT_TRUE(Holds());
}

TEST_F(SafeAutopilotTest, APilotWhoTakesOverHearsNothingMore) {
  const auto safe = Make();
  safe->Send(Ahead());
  link_.Set([](VehicleState&, LinkHealth& health) { health.pilot_allows = false; });
  EXPECT_TRUE(Eventually([&] { return link_.silent() && !link_.sent(); }));
  safe->Send(Ahead());
  EXPECT_FALSE(link_.sent());
}

TEST_F(SafeAutopilotTest, ASwitchThatIsNotToldMustBeAllowed) {
  link_.Set([](VehicleState&, LinkHealth& health) { health.pilot_allows.reset(); });
  {
    const auto safe = Make();
    safe->Send(Ahead());
    EXPECT_FALSE(link_.sent());
  }
  const auto safe = Make({.limits = {}, .pilot_untold = true});
  safe->Send(Ahead());
  EXPECT_TRUE(link_.sent());
}

TEST_F(SafeAutopilotTest, AnOldStateIsHeld) {
  const auto safe = Make();
  link_.Set([](VehicleState&, LinkHealth& health) { health.state_age_s = 0.7; });
  safe->Send(Ahead());
  EXPECT_TRUE(Holds());
}

TEST_F(SafeAutopilotTest, FlightCodeNeverSeesAStateThatIsNoNumber) {
  link_.Set([](VehicleState& state, LinkHealth&) { state.p_NB = {1, 2, -3}; });
  const auto safe = Make();
  EXPECT_EQ(safe->State().p_NB, Eigen::Vector3d(1, 2, -3));
  link_.Set(
      [](VehicleState& state, LinkHealth&) { state.p_NB.x() = std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_EQ(safe->State().p_NB, Eigen::Vector3d(1, 2, -3));
  safe->Send(Ahead());
  EXPECT_TRUE(Holds());
}

TEST_F(SafeAutopilotTest, ASetpointThatIsNoNumberIsNotSent) {
  const auto safe = Make();
  safe->Send(VelocitySetpoint{{std::nan(""), 0, 0}, 0});
  EXPECT_TRUE(Holds());
}

TEST_F(SafeAutopilotTest, ATargetLostForLongIsHeld) {
  const auto safe = Make();
  safe->TargetLostFor(11);
  safe->Send(Ahead());
  EXPECT_TRUE(Holds());
}

TEST_F(SafeAutopilotTest, ADryRunReckonsAndSendsNothing) {
  const auto safe = Make({.limits = {}, .dry_run = true});
  safe->Send(Ahead());
  ASSERT_TRUE(safe->sent());
  EXPECT_EQ(std::get<VelocitySetpoint>(*safe->sent()).v_H, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(link_.sends(), 0);
}

TEST_F(SafeAutopilotTest, EveryChangeIsToldOnce) {
  const auto safe = Make();
  safe->Send(Ahead());
  safe->Send(Ahead());
  image_age_s_ = 2;
  safe->Send(Ahead());
  safe->Send(Ahead());
  std::vector<Hazard> hazards;
  for (const SafetyChange& change : safe->TakeChanges()) hazards.push_back(change.hazard);
  // The thread may have been there first, when nothing was asked for yet.
  if (!hazards.empty() && hazards.front() == Hazard::kNoSetpoint) hazards.erase(hazards.begin());
  EXPECT_EQ(hazards, (std::vector{Hazard::kNone, Hazard::kImageStale}));
  EXPECT_TRUE(safe->TakeChanges().empty());
}

TEST_F(SafeAutopilotTest, AnAircraftThatIsLetGoIsToldToStandStillUntilItDoes) {
  link_.Set([](VehicleState& state, LinkHealth&) {
    state.landed = false, state.mode = FlightMode::kVelocity, state.v_N = {1, 0, 0};
  });
  const auto safe = Make();
  safe->Send(Ahead());
  std::atomic<bool> held = false, gone = false;
  std::thread aircraft([&] {
    held = Eventually([&] { return Holds(); });
    EXPECT_FALSE(gone);  // it moves still
    link_.Set([](VehicleState& state, LinkHealth&) { state.v_N.setZero(); });
  });
  const auto released = safe->LetGo({.still_s = 0.05, .max_s = kDeadline_s});
  gone = true;
  aircraft.join();
  EXPECT_TRUE(held);
  ASSERT_TRUE(released);
  EXPECT_EQ(released->how, Release::kHeld);
  EXPECT_GE(released->after_s, 0.05);
  EXPECT_FALSE(link_.sent());
  // From then on it is not ours, whatever anybody asks for.
  const int sends = link_.sends();
  safe->Send(Ahead());
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_EQ(link_.sends(), sends);
}

TEST_F(SafeAutopilotTest, WhoDoesNotObeyIsLetGoAllTheSame) {
  link_.Set([](VehicleState& state, LinkHealth&) {
    state.landed = false, state.mode = FlightMode::kVelocity, state.v_N = {0, 0, 0.9};
  });
  const auto safe = Make();
  safe->Send(Ahead());
  EXPECT_EQ(safe->LetGo({.max_s = 0.1})->how, Release::kNotObeyed);
  EXPECT_FALSE(link_.sent());
  EXPECT_TRUE(link_.silent());
}

TEST_F(SafeAutopilotTest, WhatThePilotHasIsNotHeldForAMoment) {
  link_.Set([](VehicleState& state, LinkHealth& health) {
    state.landed = false, state.v_N = {0, 0, 0.9};
    health.pilot_allows = false;
  });
  const auto safe = Make();
  EXPECT_EQ(safe->LetGo()->how, Release::kPilot);
  EXPECT_EQ(link_.sends(), 0);
}

TEST_F(SafeAutopilotTest, ADryRunHasNothingToLetGo) {
  link_.Set([](VehicleState& state, LinkHealth&) { state.landed = false, state.v_N = {0, 0, 0.9}; });
  const auto safe = Make({.limits = {}, .dry_run = true});
  EXPECT_FALSE(safe->LetGo());
  EXPECT_EQ(link_.sends(), 0);
}

TEST_F(SafeAutopilotTest, ItsEndSilencesTheLink) {
  {
    const auto safe = Make();
    safe->Send(Ahead());
  }
  EXPECT_TRUE(link_.silent());
}

}  // namespace
}  // namespace kestrel::control
