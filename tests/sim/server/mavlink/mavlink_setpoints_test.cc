// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_setpoints.h"

#include <gtest/gtest.h>

#include <limits>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using namespace control::wire::mavlink;
using Eigen::Vector3d;

// Of the mask: 1 the position, 8 the velocity, 64 the acceleration, times 7; 1024 yaw, 2048 yaw rate.
constexpr int kVelocityAndRate = 7 + 7 * 64 + 1024, kVelocityAndYaw = 7 + 7 * 64 + 2048;
constexpr int kPositionAndYaw = 7 * 8 + 7 * 64 + 2048;

// Looks east, from (10, 20, -5).
control::VehicleState East() {
  control::VehicleState state;
  state.p_NB = {10, 20, -5};
  state.R_NB = HeadingRotation(M_PI / 2);
  return state;
}

SetPositionTargetLocalNed Message(int frame, int mask) {
  SetPositionTargetLocalNed m;
  m.x = 1, m.y = 2, m.z = -3, m.vx = 4, m.vy = 5, m.vz = 6, m.yaw = 0.25F, m.yaw_rate = 0.5F;
  m.type_mask = static_cast<std::uint16_t>(mask), m.coordinate_frame = static_cast<std::uint8_t>(frame);
  return m;
}

std::optional<control::Setpoint> Understood(const SetPositionTargetLocalNed& message,
                                            const Dialect& dialect) {
  const auto setpoint = MavlinkSetpoint::Read(message, East(), dialect);
  if (!setpoint) return std::nullopt;
  return setpoint->At(East());
}

TEST(MavlinkSetpoints, AVelocityIsThatOfItsFrame) {
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    const auto heading =
        std::get<control::VelocitySetpoint>(*Understood(Message(8, kVelocityAndRate), *dialect));
    EXPECT_LT((heading.v_H - Vector3d(4, 5, 6)).norm(), 1e-9);
    EXPECT_EQ(heading.yaw_rate, 0.5);
    // Four to the north and five to the east are five ahead and four to the left.
    const auto north =
        std::get<control::VelocitySetpoint>(*Understood(Message(1, kVelocityAndRate), *dialect));
    EXPECT_LT((north.v_H - Vector3d(5, -4, 6)).norm(), 1e-9);
    // To a heading: to the left.
    const auto to_yaw =
        std::get<control::VelocitySetpoint>(*Understood(Message(8, kVelocityAndYaw), *dialect));
    EXPECT_LT(to_yaw.yaw_rate, -0.5);
  }
}

TEST(MavlinkSetpoints, AVelocityInNKeepsItsCourseWhenTheAircraftTurns) {
  const auto setpoint = MavlinkSetpoint::Read(Message(1, kVelocityAndRate), East(), kPx4);
  control::VehicleState north = East();
  north.R_NB.setIdentity();
  EXPECT_LT((std::get<control::VelocitySetpoint>(setpoint->At(north)).v_H - Vector3d(4, 5, 6)).norm(), 1e-9);
}

TEST(MavlinkSetpoints, APositionIsThatOfItsFrame) {
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    const auto in_n = std::get<control::PositionSetpoint>(*Understood(Message(1, kPositionAndYaw), *dialect));
    EXPECT_LT((in_n.p_N - Vector3d(1, 2, -3)).norm(), 1e-9);
    EXPECT_EQ(in_n.yaw, 0.25);
    // Without a yaw, the one that it has.
    const auto no_yaw =
        std::get<control::PositionSetpoint>(*Understood(Message(1, kPositionAndYaw + 1024), *dialect));
    EXPECT_NEAR(no_yaw.yaw, M_PI / 2, 1e-12);
  }
  const auto place = [](int frame) {
    return std::get<control::PositionSetpoint>(*Understood(Message(frame, kPositionAndYaw), kArduPilot)).p_N;
  };
  EXPECT_LT((place(7) - Vector3d(11, 22, -8)).norm(), 1e-9);
  EXPECT_LT((place(8) - Vector3d(1, 2, -3)).norm(), 1e-9);
  EXPECT_LT((place(9) - Vector3d(8, 21, -8)).norm(), 1e-9);
}

TEST(MavlinkSetpoints, FramesAndMasksThatTheStackRefusesAreRefused) {
  for (int frame = 0; frame < 25; ++frame) {
    const bool both = frame == 1 || frame == 8, one = both || frame == 7 || frame == 9;
    EXPECT_EQ(Understood(Message(frame, kVelocityAndRate), kPx4).has_value(), both) << frame;
    EXPECT_EQ(Understood(Message(frame, kVelocityAndRate), kArduPilot).has_value(), one) << frame;
  }
  EXPECT_FALSE(Understood(Message(8, kPositionAndYaw), kPx4));  // its body has no positions
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    for (const int wrong : {kVelocityAndRate + 8, kVelocityAndRate + 32, kVelocityAndRate - 64,
                            kVelocityAndRate + 512, kPositionAndYaw + 4, kPositionAndYaw - 2048, 4095}) {
      EXPECT_FALSE(Understood(Message(1, wrong), *dialect)) << wrong;
    }
    SetPositionTargetLocalNed nan = Message(1, kVelocityAndRate);
    nan.vy = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(Understood(nan, *dialect));
  }
}

TEST(MavlinkSetpoints, RatesWithoutAnAttitudeAreRates) {
  SetAttitudeTarget m;
  m.q = {1, 0, 0, 0};
  m.body_roll_rate = 0.25F, m.body_pitch_rate = -0.5F, m.body_yaw_rate = 0.75F, m.thrust = 0.5F;
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    m.type_mask = 128;
    const auto read = MavlinkSetpoint::Read(m, *dialect);
    ASSERT_TRUE(read);
    const auto rates = std::get<control::RateSetpoint>(read->At(East()));
    EXPECT_EQ(rates.w_B, Vector3d(0.25, -0.5, 0.75));
    EXPECT_EQ(rates.thrust, 0.5);
    for (const int left_out : {1, 2, 4, 64}) {
      m.type_mask = static_cast<std::uint8_t>(128 + left_out);
      EXPECT_FALSE(MavlinkSetpoint::Read(m, *dialect)) << left_out;
    }
  }
}

TEST(MavlinkSetpoints, AttitudesAndTheirRates) {
  const Eigen::Quaterniond q(RotationFromTaitBryan({.yaw = M_PI / 2, .pitch = -0.2, .roll = 0.1}));
  SetAttitudeTarget m;
  m.q = {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
         static_cast<float>(q.z())};
  m.body_yaw_rate = 0.5F, m.thrust = 0.6F;
  const auto read = [&m](int mask, const Dialect& dialect) {
    m.type_mask = static_cast<std::uint8_t>(mask);
    return MavlinkSetpoint::Read(m, dialect);
  };
  const auto flown = [&](int mask, const Dialect& dialect) {
    return std::get<control::AttitudeSetpoint>(read(mask, dialect)->At(East()));
  };
  for (const control::AttitudeSetpoint& attitude :
       {flown(3, kPx4), flown(7, kPx4), flown(0, kArduPilot), flown(7, kArduPilot)}) {
    EXPECT_NEAR(attitude.roll, 0.1, 1e-6);
    EXPECT_NEAR(attitude.pitch, -0.2, 1e-6);
    EXPECT_NEAR(attitude.thrust, 0.6, 1e-6);
  }
  EXPECT_NEAR(flown(3, kPx4).yaw_rate, 0.5, 1e-6);
  EXPECT_NEAR(flown(7, kPx4).yaw_rate, 0, 1e-6);
  EXPECT_NEAR(flown(0, kArduPilot).yaw_rate, 0.5 * std::cos(0.1) * std::cos(0.2), 1e-6);
  EXPECT_FALSE(read(0, kPx4));        // follows the rates in place of the attitude
  EXPECT_FALSE(read(3, kArduPilot));  // all the rates or none
  for (const Dialect* dialect : {&kPx4, &kArduPilot}) {
    EXPECT_TRUE(read(7, *dialect));
    EXPECT_FALSE(read(7 + 128, *dialect));
    EXPECT_FALSE(read(7 + 64, *dialect));
  }
  m.q[0] = 1;
  EXPECT_FALSE(read(7, kPx4));
}

}  // namespace
}  // namespace kestrel::sim
