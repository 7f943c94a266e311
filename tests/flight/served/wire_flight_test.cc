// SPDX-License-Identifier: Apache-2.0
#include "flight/served/wire_flight.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/diagnostics.h"
#include "flight/served/link_faults.h"

namespace kestrel::flight {
namespace {

using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Images every 0.05 s that come after 0.01 s, are decided on 0.015 s after they were given and heard 0.018 s
// after it, by the program that has counted 7 before the first that is flown.
WireFlown Flown(int images) {
  WireFlown flown;
  for (int i = 0; i < images + 10; ++i) flown.published.push_back({100 + 0.05 * i, 100 + 0.05 * i});
  for (int i = 0; i < images; ++i) {
    const double given_s = flown.published[static_cast<std::size_t>(i + 3)].t_s;
    const control::VelocitySetpoint setpoint{{0.01 * i, 0.5, 0}, 0};
    flown.images.push_back({i + 7, given_s + 0.01, given_s + 0.015, setpoint, "descend"});
    flown.heard.push_back({given_s + 0.018, setpoint});
  }
  return flown;
}

TEST(AddedLatency, IsFromAnImageUntilTheSetpointMadeOfItIsHeard) {
  const auto latency_s = AddedLatency_s(Flown(50), Wire::kMavlink);
  EXPECT_THAT(latency_s, SizeIs(50));
  EXPECT_THAT(latency_s, Each(DoubleNear(0.018, 1e-9)));
}

TEST(AddedLatency, OneThatComesAfterTheNextImageWasGivenIsNotTakenForThatOnes) {
  WireFlown flown = Flown(50);
  flown.images[20].came_s += 0.045, flown.images[20].decided_s += 0.045, flown.heard[20].t_s += 0.045;
  const auto latency_s = AddedLatency_s(flown, Wire::kMavlink);
  ASSERT_THAT(latency_s, SizeIs(50));
  EXPECT_NEAR(latency_s[20], 0.063, 1e-9);
  EXPECT_NEAR(latency_s[19], 0.018, 1e-9);
  EXPECT_NEAR(latency_s[21], 0.018, 1e-9);
}

TEST(AddedLatency, AnImageThatIsLostOnTheWayShiftsNothing) {
  WireFlown flown = Flown(50);
  flown.images.erase(flown.images.begin() + 25);  // and was not counted
  flown.heard.erase(flown.heard.begin() + 25);
  for (std::size_t i = 25; i < flown.images.size(); ++i) --flown.images[i].sequence;
  const auto latency_s = AddedLatency_s(flown, Wire::kMavlink);
  EXPECT_THAT(latency_s, SizeIs(49));
  EXPECT_THAT(latency_s, Each(DoubleNear(0.018, 1e-9)));
}

TEST(AddedLatency, ALateSetpointIsKnownByItsValue) {
  WireFlown flown = Flown(50);
  flown.heard[20].t_s += 0.048;  // after the decision on the next image
  const auto latency_s = AddedLatency_s(flown, Wire::kAfcs);
  ASSERT_THAT(latency_s, SizeIs(50));
  EXPECT_NEAR(latency_s[20], 0.066, 1e-9);
}

TEST(AddedLatency, AnAttitudeIsTheFirstThatCanHaveLeftAfterTheDecision) {
  WireFlown flown = Flown(50);
  for (ReceivedSetpoint& heard : flown.heard)
    heard.setpoint = control::AttitudeSetpoint{heard.t_s, 0, 0, 0.5};
  // One that left 1 ms before the decision on image 20 and comes after it.
  flown.heard.insert(flown.heard.begin() + 20,
                     {flown.images[20].decided_s + 0.00195, control::AttitudeSetpoint{0.1, 0.1, 0, 0.5}});
  const auto latency_s = AddedLatency_s(flown, Wire::kAscTec);
  EXPECT_THAT(latency_s, SizeIs(50));
  EXPECT_THAT(latency_s, Each(DoubleNear(0.018, 1e-9)));
}

TEST(HardwareProgram, WhereItIsNotThereTheRemedyIsTold) {
  const char* given = std::getenv("KESTREL_HARDWARE_PROGRAM");
  const std::string before = given ? given : "";
  setenv("KESTREL_HARDWARE_PROGRAM", "/nowhere/kestrel", 1);
  try {
    HardwareProgram();
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("/nowhere/kestrel"));
    EXPECT_THAT(e.what(), HasSubstr("./kestrel fly"));
  }
  if (given)
    setenv("KESTREL_HARDWARE_PROGRAM", before.c_str(), 1);
  else
    unsetenv("KESTREL_HARDWARE_PROGRAM");
}

// A cut of the link at 10 s, to which the program reacts as it should.
WireFlown CutLink() {
  WireFlown flown;
  flown.fault_s = 10;
  flown.events = {{9, "safety", "none, fly"},
                  {10.5, "safety", "state lost, hold"},
                  {12.5, "safety", "state lost, silence"}};
  for (int i = 0; i < 50; ++i) flown.truth.push_back({10 + 0.05 * i, {0.1, 0, 0}, false});
  return flown;
}

TEST(JudgeFault, AsWrittenIsRight) {
  const FaultJudgement j = JudgeFault(kFaults[0], CutLink(), {});
  EXPECT_THAT(j.wrong, IsEmpty());
  EXPECT_NEAR(j.reaction_s.value(), 0.5, 1e-9);
}

TEST(JudgeFault, EachDeparture) {
  const auto wrong = [](const auto& change) {
    WireFlown flown = CutLink();
    change(flown);
    return JudgeFault(kFaults[0], flown, {}).wrong.size();
  };
  EXPECT_EQ(wrong([](WireFlown& f) { f.events[1].t_s = 10.7; }), 1U);                // late
  EXPECT_GE(wrong([](WireFlown& f) { f.events[1].is = "image stale, hold"; }), 1U);  // another
  EXPECT_EQ(wrong([](WireFlown& f) { f.events.pop_back(); }), 1U);                   // never silent
  EXPECT_EQ(wrong([](WireFlown& f) { f.events[2].t_s = 14; }), 1U);                  // silent late
  EXPECT_EQ(wrong([](WireFlown& f) { f.events.push_back({13, "safety", "none, fly"}); }), 1U);
  EXPECT_EQ(wrong([](WireFlown& f) { f.truth.back().v_N = {40, 0, 0}; }), 1U);  // flies away
  EXPECT_EQ(wrong([](WireFlown& f) { f.fault_s.reset(); }), 1U);
}

TEST(JudgeFault, WithoutACameraTheAircraftIsHeldAndSinks) {
  const auto wrong = [](const control::VelocitySetpoint& hold, const control::VelocitySetpoint& later,
                        double sink_m_s) {
    WireFlown flown;
    flown.fault_s = 10;
    flown.events = {{10.45, "safety", "image stale, hold"}, {12.45, "safety", "image stale, sink"}};
    flown.heard = {{9.9, control::VelocitySetpoint{{0.3, 0, 0.2}, 0}}, {10.46, hold}, {12.46, later}};
    flown.truth = {{11, {0, 0, 1}, false}, {13, {0, 0, sink_m_s}, false}};
    return JudgeFault(kFaults[1], flown, {}).wrong.size();
  };
  const control::VelocitySetpoint none, down{{0, 0, 0.5}, 0}, on{{0.3, 0, 0.2}, 0};
  EXPECT_EQ(wrong(none, down, 0.5), 0U);
  EXPECT_EQ(wrong(on, down, 0.5), 1U);
  EXPECT_EQ(wrong(none, on, 0.5), 1U);
  EXPECT_EQ(wrong(none, down, 0), 1U);
}

TEST(JudgeFault, WhereItIsToFlyOnItMustLandInItsPlace) {
  WireFlown flown;
  flown.fault_s = 10;
  flown.served.outcome = "landed";
  flown.served.metrics["touchdown_error_m"] = 0.1;
  EXPECT_THAT(JudgeFault(kFaults[3], flown, {}).wrong, IsEmpty());
  flown.served.metrics["touchdown_error_m"] = 0.3;
  EXPECT_THAT(JudgeFault(kFaults[3], flown, {}).wrong, SizeIs(1));
  flown.served.outcome = "completed";
  EXPECT_THAT(JudgeFault(kFaults[3], flown, {}).wrong, SizeIs(2));
}

}  // namespace
}  // namespace kestrel::flight
