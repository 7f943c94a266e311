// SPDX-License-Identifier: Apache-2.0
#include "control/wire/mavlink_dialects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kestrel::control::wire::mavlink {
namespace {

constexpr Target kTarget{3, 4};
const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(),
                      kZ = Eigen::Vector3d::UnitZ();

// Yaw, then pitch, then roll, by their definition.
Eigen::Quaterniond Turned(double yaw, double pitch, double roll) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw, kZ) * Eigen::AngleAxisd(pitch, kY) *
                            Eigen::AngleAxisd(roll, kX));
}

TEST(MavlinkDialects, AVelocityGoesOutInTheHeadingFrameWithItsYawRate) {
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    const auto m = std::get<SetPositionTargetLocalNed>(
        ToMessage(VelocitySetpoint{{1, 2, 3}, 0.5}, 9, *dialect, kTarget, 1234));
    EXPECT_EQ(m.type_mask, 0x05C7);
    EXPECT_EQ(m.coordinate_frame, 8);
    EXPECT_EQ(Eigen::Vector3f(m.vx, m.vy, m.vz), Eigen::Vector3f(1, 2, 3));
    EXPECT_EQ(m.yaw_rate, 0.5F);
    EXPECT_EQ(m.time_boot_ms, 1234U);
    EXPECT_EQ(m.target_system, 3);
    EXPECT_EQ(m.target_component, 4);
  }
}

TEST(MavlinkDialects, APositionGoesOutInNWithItsYaw) {
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    const auto m = std::get<SetPositionTargetLocalNed>(
        ToMessage(PositionSetpoint{{1, 2, -3}, 0.5}, 9, *dialect, kTarget, 0));
    EXPECT_EQ(m.type_mask, 8 + 16 + 32 + 64 + 128 + 256 + 2048);
    EXPECT_EQ(m.coordinate_frame, 1);
    EXPECT_EQ(Eigen::Vector3f(m.x, m.y, m.z), Eigen::Vector3f(1, 2, -3));
    EXPECT_EQ(m.yaw, 0.5F);
  }
}

TEST(MavlinkDialects, RatesAreSentWithoutAnAttitude) {
  const RateSetpoint setpoint{{0.3, -0.2, 0.7}, 0.6};
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    const auto m = std::get<SetAttitudeTarget>(ToMessage(setpoint, 2, *dialect, kTarget, 5));
    EXPECT_EQ(m.type_mask, 128);  // ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE
    EXPECT_EQ(m.body_roll_rate, 0.3F);
    EXPECT_EQ(m.body_pitch_rate, -0.2F);
    EXPECT_EQ(m.body_yaw_rate, 0.7F);
    EXPECT_EQ(m.thrust, 0.6F);
    EXPECT_EQ(m.target_system, 3);
    EXPECT_EQ(m.time_boot_ms, 5u);
  }
  EXPECT_EQ(ModeFor(setpoint), FlightMode::kRates);
}

TEST(MavlinkDialects, AnAttitudeHasItsYawAndTheRatesThatEachWants) {
  const AttitudeSetpoint setpoint{.roll = 0.3, .pitch = -0.2, .yaw_rate = 0.7, .thrust = 0.6};
  const Eigen::Quaterniond R_NB = Turned(2, -0.2, 0.3);
  const auto px4 = std::get<SetAttitudeTarget>(ToMessage(setpoint, 2, kPx4, kTarget, 0));
  const auto ardupilot = std::get<SetAttitudeTarget>(ToMessage(setpoint, 2, kArduPilot, kTarget, 0));
  for (const SetAttitudeTarget& m : {px4, ardupilot}) {
    EXPECT_LT(Eigen::Quaterniond(m.q[0], m.q[1], m.q[2], m.q[3]).angularDistance(R_NB), 1e-6);
    EXPECT_EQ(m.thrust, 0.6F);
    EXPECT_EQ(m.target_system, 3);
  }
  EXPECT_EQ(px4.type_mask, 1 + 2);
  EXPECT_EQ(px4.body_yaw_rate, 0.7F);
  EXPECT_EQ(ardupilot.type_mask, 0);
  const Eigen::Vector3f w_B(ardupilot.body_roll_rate, ardupilot.body_pitch_rate, ardupilot.body_yaw_rate);
  EXPECT_LT((R_NB * w_B.cast<double>() - 0.7 * kZ).norm(), 1e-6);
}

TEST(MavlinkDialects, ModesAndCommands) {
  EXPECT_EQ(kPx4.setpoint_mode, 0x00060000U);
  EXPECT_EQ(kPx4.land_mode, 0x06040000U);
  EXPECT_EQ(kPx4.return_mode, 0x05040000U);
  const CommandLong offboard = SetCustomMode(kPx4.setpoint_mode, kPx4, kTarget);
  EXPECT_EQ(offboard.command, 176);
  EXPECT_EQ(offboard.target_system, 3);
  EXPECT_EQ(offboard.param1, 1);
  EXPECT_EQ(offboard.param2, 6);
  EXPECT_EQ(offboard.param3, 0);
  const CommandLong land = SetCustomMode(kPx4.land_mode, kPx4, kTarget);
  EXPECT_EQ(land.param2, 4);
  EXPECT_EQ(land.param3, 6);
  EXPECT_EQ(SetCustomMode(kArduPilot.setpoint_mode, kArduPilot, kTarget).param2, 4);
  EXPECT_EQ(SetCustomMode(kArduPilot.land_mode, kArduPilot, kTarget).param2, 9);
  EXPECT_EQ(Arm(true, kTarget).command, 400);
  EXPECT_EQ(Arm(true, kTarget).param1, 1);
  EXPECT_EQ(Arm(false, kTarget).param1, 0);
  EXPECT_EQ(TakeOff(5, 600, kArduPilot, kTarget).command, 22);
  EXPECT_EQ(TakeOff(5, 600, kArduPilot, kTarget).param7, 5);
  EXPECT_EQ(TakeOff(5, 600, kPx4, kTarget).param7, 605);
  EXPECT_TRUE(std::isnan(TakeOff(5, 600, kPx4, kTarget).param5));
  EXPECT_EQ(SetMessageInterval(32, 50, kTarget).command, 511);
  EXPECT_EQ(SetMessageInterval(32, 50, kTarget).param1, 32);
  EXPECT_EQ(SetMessageInterval(32, 50, kTarget).param2, 20000);
}

TEST(MavlinkDialects, TheLandingTargetIsWhereEachLooksForIt) {
  const Pose X_NB{Turned(M_PI / 2, 0, 0), {10, 20, -5}};  // looks east
  const Eigen::Vector3d p_NT(10, 22, 0);                  // 2 m ahead and 5 m below
  const LandingTarget px4 = ToLandingTarget(p_NT, X_NB, kPx4, 99);
  EXPECT_EQ(px4.frame, 1);
  EXPECT_EQ(Eigen::Vector3f(px4.x, px4.y, px4.z), Eigen::Vector3f(10, 22, 0));
  const LandingTarget ardupilot = ToLandingTarget(p_NT, X_NB, kArduPilot, 99);
  EXPECT_EQ(ardupilot.frame, 12);
  EXPECT_LT((Eigen::Vector3f(ardupilot.x, ardupilot.y, ardupilot.z) - Eigen::Vector3f(2, 0, 5)).norm(), 1e-5);
  for (const LandingTarget& m : {px4, ardupilot}) {
    EXPECT_EQ(m.time_usec, 99U);
    EXPECT_EQ(m.position_valid, 1);
    EXPECT_NEAR(m.distance, std::sqrt(29), 1e-5);
  }
}

TEST(MavlinkDialects, AreKnownByTheirHeartbeat) {
  EXPECT_EQ(DialectOf({.autopilot = 12}), &kPx4);
  EXPECT_EQ(DialectOf({.autopilot = 3}), &kArduPilot);
  EXPECT_EQ(DialectOf(CompanionHeartbeat()), nullptr);
  EXPECT_EQ(CompanionHeartbeat().type, 18);
  EXPECT_EQ(CompanionHeartbeat().mavlink_version, 3);
}

Attitude Level(std::uint32_t time_boot_ms) { return {.time_boot_ms = time_boot_ms}; }

TEST(MavlinkTelemetry, NoStateBeforeAllOfItCame) {
  Telemetry telemetry;
  EXPECT_FALSE(telemetry.State(kPx4));
  EXPECT_TRUE(telemetry.Handle(Heartbeat{}));
  EXPECT_TRUE(telemetry.Handle(Level(1000)));
  EXPECT_FALSE(telemetry.State(kPx4));
  EXPECT_TRUE(telemetry.Handle(LocalPositionNed{.time_boot_ms = 1000}));
  EXPECT_TRUE(telemetry.State(kPx4));
  // The position no longer comes.
  EXPECT_TRUE(telemetry.Handle(Level(1500)));
  EXPECT_TRUE(telemetry.State(kPx4));
  EXPECT_TRUE(telemetry.Handle(Level(1501)));
  EXPECT_FALSE(telemetry.State(kPx4));
}

TEST(MavlinkTelemetry, AttitudeAndPositionAreOfOneTime) {
  const Eigen::Quaterniond R_NB = Turned(1, 0.1, -0.2);
  const auto q = R_NB.cast<float>();
  Telemetry telemetry;
  telemetry.Handle(Heartbeat{});
  telemetry.Handle(AttitudeQuaternion{
      .time_boot_ms = 2000, .q1 = q.w(), .q2 = q.x(), .q3 = q.y(), .q4 = q.z(), .rollspeed = 0.5F});
  telemetry.Handle(LocalPositionNed{.time_boot_ms = 1900, .x = 1, .y = 2, .z = -3, .vx = 10, .vz = 1});
  VehicleState state = telemetry.State(kPx4).value();
  EXPECT_DOUBLE_EQ(state.t_s, 2);
  EXPECT_LT((state.p_NB - Eigen::Vector3d(2, 2, -2.9)).norm(), 1e-6);
  EXPECT_EQ(state.v_N, Eigen::Vector3d(10, 0, 1));
  EXPECT_LT(state.R_NB.angularDistance(R_NB), 1e-6);
  EXPECT_EQ(state.w_B, Eigen::Vector3d(0.5, 0, 0));
  EXPECT_TRUE(state.R_NB_inertial && state.R_NB_inertial->isApprox(state.R_NB));
  telemetry.Handle(LocalPositionNed{.time_boot_ms = 2100});
  state = telemetry.State(kPx4).value();
  EXPECT_DOUBLE_EQ(state.t_s, 2.1);
  EXPECT_LT(state.R_NB.angularDistance(R_NB * Turned(0, 0, 0.05)), 1e-6);
  // By its angles, the same attitude.
  telemetry.Handle(Attitude{.time_boot_ms = 2100, .roll = -0.2F, .pitch = 0.1F, .yaw = 1});
  EXPECT_LT(telemetry.State(kPx4)->R_NB.angularDistance(R_NB), 1e-6);
}

TEST(MavlinkTelemetry, TheModeIsThatOfWhatWasSent) {
  Telemetry telemetry;
  telemetry.Handle(Level(0));
  telemetry.Handle(LocalPositionNed{});
  const auto mode = [&telemetry](std::uint32_t custom_mode, bool armed, const Dialect& dialect) {
    telemetry.Handle(
        Heartbeat{.custom_mode = custom_mode, .base_mode = static_cast<std::uint8_t>(armed ? 129 : 1)});
    return telemetry.State(dialect)->mode;
  };
  EXPECT_EQ(mode(0x60000, false, kPx4), FlightMode::kStopped);
  EXPECT_EQ(mode(0x60000, true, kPx4), FlightMode::kVelocity);
  EXPECT_EQ(mode(4, true, kPx4), FlightMode::kHold);
  EXPECT_EQ(mode(4, true, kArduPilot), FlightMode::kVelocity);
  telemetry.Sent(PositionSetpoint{});
  EXPECT_EQ(mode(4, true, kArduPilot), FlightMode::kPosition);
  telemetry.Sent(AttitudeSetpoint{});
  EXPECT_EQ(mode(4, true, kArduPilot), FlightMode::kAttitude);
  telemetry.Handle(ExtendedSysState{.landed_state = 3});
  EXPECT_EQ(mode(4, true, kArduPilot), FlightMode::kTakeOff);
}

TEST(MavlinkTelemetry, LandedAsItSaysOrElseAsItIsArmed) {
  Telemetry telemetry;
  telemetry.Handle(Level(0));
  telemetry.Handle(LocalPositionNed{});
  telemetry.Handle(Heartbeat{.base_mode = 128});
  EXPECT_FALSE(telemetry.State(kPx4)->landed);
  telemetry.Handle(ExtendedSysState{.landed_state = 1});
  EXPECT_TRUE(telemetry.State(kPx4)->landed);
  telemetry.Handle(ExtendedSysState{.landed_state = 4});
  EXPECT_FALSE(telemetry.State(kPx4)->landed);
  telemetry.Handle(ExtendedSysState{.landed_state = 0});
  telemetry.Handle(Heartbeat{});
  EXPECT_TRUE(telemetry.State(kPx4)->landed);
}

TEST(MavlinkTelemetry, WhatIsNoNumberIsNotTaken) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  Telemetry telemetry;
  EXPECT_FALSE(telemetry.Handle(Attitude{.pitch = kNone}));
  EXPECT_FALSE(telemetry.Handle(Attitude{.yawspeed = std::numeric_limits<float>::infinity()}));
  EXPECT_FALSE(telemetry.Handle(AttitudeQuaternion{}));
  EXPECT_FALSE(telemetry.Handle(AttitudeQuaternion{.q1 = kNone}));
  EXPECT_FALSE(telemetry.Handle(AttitudeQuaternion{.q1 = 1, .rollspeed = kNone}));
  EXPECT_FALSE(telemetry.Handle(LocalPositionNed{.z = kNone}));
  EXPECT_FALSE(telemetry.Handle(Statustext{}));
}

TEST(MavlinkTelemetry, WhatCannotBeIsNotTaken) {
  Telemetry telemetry;
  EXPECT_TRUE(telemetry.Handle(LocalPositionNed{.x = 9e4F, .vx = 150}));
  EXPECT_FALSE(telemetry.Handle(LocalPositionNed{.x = 3e38F}));
  EXPECT_FALSE(telemetry.Handle(LocalPositionNed{.vz = 1e4F}));
  EXPECT_TRUE(telemetry.Handle(Attitude{.roll = -3.14F, .rollspeed = 30}));
  EXPECT_FALSE(telemetry.Handle(Attitude{.roll = 3e38F}));
  EXPECT_FALSE(telemetry.Handle(Attitude{.rollspeed = 1e3F}));
  EXPECT_FALSE(telemetry.Handle(AttitudeQuaternion{.q1 = 1.1F}));
}

}  // namespace
}  // namespace kestrel::control::wire::mavlink
