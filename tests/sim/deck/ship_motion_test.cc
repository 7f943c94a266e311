// SPDX-License-Identifier: Apache-2.0
#include "sim/deck/ship_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kG = 9.80665;

TEST(ShipMotionTest, InLongWavesAShipGoesWithTheSurface) {
  const double w = 0.15, k = w * w / kG;
  const ShipResponse ahead = ResponseOf({}, 0, w, std::numbers::pi);
  EXPECT_NEAR(ahead.heave, 1, 0.02);
  EXPECT_NEAR(ahead.pitch / k, 1, 0.02);
  EXPECT_NEAR(ahead.roll, 0, 1e-12);
  const ShipResponse abeam = ResponseOf({.roll_period_s = 4}, 0, w, std::numbers::pi / 2);
  EXPECT_NEAR(abeam.heave, 1, 0.02);
  EXPECT_NEAR(abeam.pitch, 0, 1e-9);
  EXPECT_NEAR(abeam.roll / k, 1, 0.02);
}

TEST(ShipMotionTest, WavesOfItsOwnLengthAndShorterHardlyMoveIt) {
  const ShipParameters ship;
  const double w = std::sqrt(2 * std::numbers::pi * kG / ship.length_m);
  EXPECT_LT(ResponseOf(ship, 0, w, std::numbers::pi).heave, 0.01);  // as much up as down along it
  EXPECT_LT(ResponseOf(ship, 0, 2 * w, std::numbers::pi).heave, 0.1);
  EXPECT_LT(ResponseOf(ship, 0, 3 * w, std::numbers::pi / 2).heave, 0.1);
}

TEST(ShipMotionTest, RollIsLargestAtItsOwnPeriodByItsDamping) {
  const ShipParameters ship;
  const double w = 2 * std::numbers::pi / ship.roll_period_s, k = w * w / kG;
  const ShipResponse at = ResponseOf(ship, 0, w, std::numbers::pi / 2);
  EXPECT_NEAR(at.roll, k * std::exp(-k * ship.draught_m) / (2 * ship.roll_damping), 1e-9);
  EXPECT_NEAR(at.roll_lag, std::numbers::pi / 2, 1e-9);
}

TEST(ShipMotionTest, ItMeetsWavesFromAheadSooner) {
  EXPECT_NEAR(ResponseOf({}, 6, 0.8, std::numbers::pi).encounter, 0.8 + 0.64 / kG * 6, 1e-12);
  EXPECT_NEAR(ResponseOf({}, 6, 0.8, 0).encounter, 0.8 - 0.64 / kG * 6, 1e-12);
}

// From the right, a ship that goes with the surface rolls to where it falls: when its elevation rises, the crest is
// still on the right, and the right side is up.
TEST(ShipMotionTest, SignsAreThoseOfTheSurface) {
  const double heading = 0.3;
  const WaveParameters from_ahead{
      .spectrum = "bretschneider", .height_m = 1, .peak_s = 24, .from_deg = Degrees(heading)};
  WaveParameters from_right = from_ahead;
  from_right.from_deg = Degrees(heading) + 90;
  const ShipParameters ship{.length_m = 8, .beam_m = 3, .draught_m = 0.4, .roll_period_s = 2};
  const ShipInWaves ahead(ship, from_ahead, heading, 0, 5), right(ship, from_right, heading, 0, 5);
  double pitch = 0, roll = 0, pitch_2 = 0, roll_2 = 0, rise_2 = 0;
  for (double t = 0; t < 300; t += 0.5) {
    const auto rise = [&](const ShipInWaves& s) {
      return (s.At(t + 0.05).heave_m - s.At(t - 0.05).heave_m) / 0.1;
    };
    pitch += rise(ahead) * ahead.At(t).pitch, pitch_2 += std::pow(ahead.At(t).pitch, 2);
    roll += rise(right) * right.At(t).roll, roll_2 += std::pow(right.At(t).roll, 2);
    rise_2 += std::pow(rise(right), 2);
  }
  EXPECT_GT(pitch / std::sqrt(pitch_2 * rise_2), 0.8);  // the crest comes from ahead: bow up while it rises
  EXPECT_LT(roll / std::sqrt(roll_2 * rise_2), -0.8);
}

}  // namespace
}  // namespace kestrel::sim
