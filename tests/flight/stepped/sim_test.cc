// SPDX-License-Identifier: Apache-2.0
#include "flight/stepped/sim.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "base/diagnostics.h"
#include "flight/simulated/runner.h"

namespace kestrel {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

SimOptions Short() {
  SimOptions options;
  options.seed = 5;
  options.overrides = {"duration_s=1.5", "start.settle_s=2"};
  return options;
}

records::Summary Flown(const SimOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  overrides.push_back("seed=" + std::to_string(*options.seed));
  return flight::RunFlight(flight::LoadScenario("landing", overrides), {}).summary;
}

TEST(Sim, WithTheMissionsSetpointsFliesTheFlightOfARun) {
  const SimOptions options = Short();
  Sim sim("landing", options);
  sim.Reset();
  while (!sim.done()) {
    const mission::Decision& decision = sim.Decide();
    sim.Step(decision.setpoint, decision.aid);
  }
  const records::Summary stepped = sim.Summarise(), flown = Flown(options);
  EXPECT_EQ(stepped.state_hash, flown.state_hash);
  EXPECT_EQ(stepped.image_hash, flown.image_hash);
  EXPECT_EQ(stepped.metrics, flown.metrics);
  EXPECT_EQ(stepped.outcome, flown.outcome);
}

TEST(Sim, ChangedByHandFliesTheFlightOfARunByItsFile) {
  const SimOptions options = Short();
  Sim sim("landing", options);
  EXPECT_THAT([&] { sim.Change("wind.mean_m_s", "7"); },
              ThrowsMessage<SimError>(HasSubstr("call reset first")));
  sim.Reset();
  EXPECT_THAT([&] { sim.Change("pilot.servo.lambda_per_s", "0.5"); },
              ThrowsMessage<SimError>(HasSubstr("nobody flies by the scenario's own mission")));
  for (int frame = 0; !sim.done(); ++frame) {
    const mission::Decision& decision = sim.Decide();
    if (frame == 8) sim.Change("wind.mean_m_s", "7");
    if (frame == 15) sim.Change("pilot.servo.lambda_per_s", "0.5");
    sim.Step(decision.setpoint, decision.aid);
  }
  EXPECT_THAT([&] { sim.Change("wind.mean_m_s", "7"); }, ThrowsMessage<SimError>(HasSubstr("after the end")));
  ASSERT_EQ(sim.flown().changes.size(), 2u);
  std::vector<std::string> made;
  for (const flight::ChangeKeys& change : sim.flown().changes)
    made.push_back(
        fmt::format("{{at_s: {}, key: {}, value: {}}}", change.at_s, change.key, change.value.text));
  SimOptions again = options;
  again.overrides.push_back(fmt::format("changes=[{}]", fmt::join(made, ", ")));
  const records::Summary changed = sim.Summarise(), flown = Flown(again);
  EXPECT_EQ(changed.state_hash, flown.state_hash);
  EXPECT_EQ(changed.image_hash, flown.image_hash);
  EXPECT_NE(changed.state_hash, Flown(options).state_hash);
  Sim from_keys("landing", again);
  from_keys.Reset();
  while (!from_keys.done()) {
    const mission::Decision& decision = from_keys.Decide();
    from_keys.Step(decision.setpoint, decision.aid);
  }
  EXPECT_EQ(from_keys.Summarise().state_hash, flown.state_hash);
}

TEST(Sim, BeginsAgainWithAnotherSeedAsIfItWereNew) {
  Sim sim("hover", Short());
  sim.Reset();
  sim.Step(control::VelocitySetpoint{{1, 0, 0}, 0});
  const Observation again = sim.Reset(6);
  SimOptions options = Short();
  options.seed = 6;
  Sim other("hover", options);
  const Observation first = other.Reset();
  EXPECT_EQ(cv::norm(again.frame->image, first.frame->image, cv::NORM_INF), 0);
  EXPECT_EQ(sim.simulator().state_hash(), other.simulator().state_hash());
}

TEST(Sim, AFlightWithoutImagesIsTheSameInItsStates) {
  SimOptions options = Short();
  Sim drawn("hover", options);
  options.images = false;
  Sim blind("hover", options);
  Observation a = drawn.Reset(), b = blind.Reset();
  while (!drawn.done()) {
    EXPECT_TRUE(b.frame->image.empty());
    EXPECT_EQ(a.frame->t_s, b.frame->t_s);
    a = drawn.Step(control::VelocitySetpoint{{0.5, 0.2, 0}, 0.1});
    b = blind.Step(control::VelocitySetpoint{{0.5, 0.2, 0}, 0.1});
  }
  EXPECT_TRUE(blind.done());
  EXPECT_EQ(drawn.simulator().state_hash(), blind.simulator().state_hash());
}

TEST(Sim, TimeGoesOnBySingleStepsOfThePhysics) {
  SimOptions options = Short();
  options.images = false;
  Sim sim("hover", options);
  sim.Reset();
  const double from_s = sim.t_s();
  for (int i = 1; i <= 100; ++i) {
    sim.Advance(sim.dt_s());
    EXPECT_NEAR(sim.t_s(), from_s + i * sim.dt_s(), 1e-9);
  }
}

TEST(Sim, TimesThatAreNoStepsOfThePhysicsAddUp) {
  SimOptions options = Short();
  options.images = false;
  Sim sim("hover", options);
  sim.Reset();
  const double from_s = sim.t_s();
  for (int i = 0; i < 30; ++i) sim.Advance(1 / 30.0);
  EXPECT_NEAR(sim.t_s(), from_s + 1, 1e-9);
  sim.Advance(0.0005);
  EXPECT_NEAR(sim.t_s(), from_s + 1, 1e-9);
  sim.Advance(0.0005);
  sim.Advance(0.0005);
  EXPECT_NEAR(sim.t_s(), from_s + 1.002, 1e-9);
}

TEST(Sim, AdvancesToItsEndAndNoFurther) {
  SimOptions options = Short();
  options.images = false;
  Sim sim("hover", options), by_parts("hover", options);
  sim.Reset();
  by_parts.Reset();
  sim.Advance(1e300);
  EXPECT_TRUE(sim.done());
  EXPECT_EQ(sim.outcome(), "completed");
  EXPECT_NEAR(sim.t_s(), 1.5, 1e-9);
  while (!by_parts.done()) by_parts.Advance(0.1);
  EXPECT_EQ(sim.simulator().state_hash(), by_parts.simulator().state_hash());
  EXPECT_EQ(sim.rows().size(), by_parts.rows().size());
}

TEST(Sim, StopsWhereItIsToldTo) {
  SimOptions options = Short();
  options.images = false;
  Sim sim("hover", options);
  sim.Reset();
  int asked = 0;
  sim.Advance(1, std::nullopt, [&] { return ++asked < 3; });
  EXPECT_EQ(asked, 3);
  EXPECT_FALSE(sim.done());
  EXPECT_LT(sim.t_s(), 0.5);
  EXPECT_TRUE(sim.Step().frame);
}

TEST(Sim, HasAnImuWhereAskedForAndIsTheSameFlight) {
  SimOptions options = Short();
  options.images = false;
  Sim without("hover", options);
  options.imu = true;
  Sim with("hover", options);
  without.Reset();
  with.Reset();
  EXPECT_TRUE(without.readings().imu.empty());
  with.Advance(0.5);
  without.Advance(0.5);
  EXPECT_NEAR(static_cast<double>(with.readings().imu.size()), 100, 1);
  EXPECT_EQ(with.simulator().state_hash(), without.simulator().state_hash());
}

TEST(Sim, GivesDepthAndFlowOfAFrameWhereAskedFor) {
  SimOptions options = Short();
  options.surfaces = true;
  Sim sim("hover", options);
  EXPECT_TRUE(sim.Reset().flow.empty());
  const Observation o = sim.Step();
  EXPECT_EQ(o.surfaces.depth_m.size(), o.frame->image.size());
  EXPECT_EQ(o.surfaces.geom.type(), CV_32S);
  EXPECT_EQ(o.flow.type(), CV_32FC2);
}

TEST(Sim, SaysHowItWasMisused) {
  Sim sim("hover", Short());
  EXPECT_THAT([&] { sim.Step(); }, ThrowsMessage<SimError>(HasSubstr("call reset first")));
  sim.Reset();
  const control::VelocitySetpoint none{{std::numeric_limits<double>::quiet_NaN(), 0, 0}, 0};
  EXPECT_THAT([&] { sim.Step(none); }, ThrowsMessage<SimError>(HasSubstr("the setpoint has a number")));
  EXPECT_THAT(
      [&] {
        sim.Step(control::RateSetpoint{{0, 0, 0}, 2});
      },
      ThrowsMessage<SimError>(HasSubstr("a thrust of 2: valid are 0 to 1")));
  EXPECT_THAT([&] { sim.Advance(-1); }, ThrowsMessage<SimError>(HasSubstr("positive")));
  sim.Finish("tired");
  EXPECT_TRUE(sim.done());
  EXPECT_EQ(sim.Summarise().outcome, "tired");
  EXPECT_THAT([&] { sim.Step(); }, ThrowsMessage<SimError>(HasSubstr("tired")));
}

TEST(Sim, RefusesWhatAScenarioDoesNotHave) {
  SimOptions options;
  options.overrides = {"wind.mean_m_z=5"};
  EXPECT_THROW(Sim("hover", options), InputError);
  EXPECT_THROW(Sim("no_such", {}), InputError);
}

}  // namespace
}  // namespace kestrel
