// SPDX-License-Identifier: Apache-2.0
#include "sim/deck/deck.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using ::testing::HasSubstr;

constexpr double kStep_s = 0.002;

DeckParameters Driving(const char* motion, double speed, double radius = 20) {
  DeckParameters p;
  p.motion = motion, p.speed_m_s = speed, p.radius_m = radius;
  p.acceleration_m_s2 = 2;
  return p;
}

Pose Begin() { return {HeadingRotation(0.4), {3, -2, -1}}; }

// A deck from 0 on, until a time.
template <class See>
void Watch(const DeckParameters& p, double until_s, See see, std::uint64_t seed = 1) {
  Deck deck(p, Begin(), seed, 0, kStep_s);
  for (double t = 0; t < until_s; t += kStep_s, deck.Step()) see(t, deck.now());
}

TEST(DeckTest, DrivesStraightAlongItsHeadingOnceItHasGatheredSpeed) {
  Watch(Driving("straight", 4), 10, [](double t, const DeckMotion& deck) {
    const double way = t < 2 ? t * t : 4 * (t - 1);
    const Eigen::Vector3d at = Begin() * Eigen::Vector3d(way, 0, 0);
    ASSERT_LT((deck.X_NT.p - at).norm(), 0.02) << t;
    ASSERT_NEAR(YawOf(deck.X_NT.R), 0.4, 1e-9);
  });
}

TEST(DeckTest, OnACircleItHasTheCirclesAccelerationAndRate) {
  int checked = 0;
  Watch(Driving("circle", 6, 20), 30, [&](double t, const DeckMotion& deck) {
    if (t < 4) return;
    ++checked;
    ASSERT_NEAR(deck.v_N.norm(), 6, 1e-3);
    ASSERT_NEAR(deck.a_N.norm(), 36.0 / 20, 1e-3);
    ASSERT_NEAR(deck.w_N.z(), 6.0 / 20, 1e-6);
    ASSERT_NEAR(deck.v_N.normalized().dot(deck.X_NT.R * Eigen::Vector3d::UnitX()), 1, 1e-6);
  });
  EXPECT_GT(checked, 1000);
}

TEST(DeckTest, AFigureOf8ComesBackThroughItsMiddleAndBendsNoSharperThanSaid) {
  double nearest = 1e9, sharpest = 0, farthest = 0;
  Watch(Driving("figure_8", 8, 20), 60, [&](double t, const DeckMotion& deck) {
    const double from = (deck.X_NT.p - Begin().p).norm();
    farthest = std::max(farthest, from);
    if (t > 15) nearest = std::min(nearest, from);
    if (t > 5) sharpest = std::max(sharpest, std::abs(deck.w_N.z()) / deck.v_N.norm());
    ASSERT_NEAR(deck.v_N.norm(), std::min(8.0, 2 * t), 0.05) << t;
  });
  EXPECT_LT(nearest, 0.1);
  EXPECT_NEAR(farthest, 60, 0.1);
  EXPECT_NEAR(sharpest, 1.0 / 20, 1e-3);
}

TEST(DeckTest, AtRandomItKeepsToItsSpeedItsBendsAndItsPlaceAndDiffersBySeed) {
  DeckParameters p = Driving("random", 5, 15);
  p.within_m = 40;
  Eigen::Vector3d ends[2];
  for (const std::uint64_t seed : {1, 2})
    Watch(
        p, 120,
        [&](double, const DeckMotion& deck) {
          ASSERT_LE(deck.v_N.norm(), 5.001);
          ASSERT_LE(std::abs(deck.w_N.z()), 1.001 / 15 * 5);
          ASSERT_LT((deck.X_NT.p - Begin().p).norm(), 90);
          ends[seed - 1] = deck.X_NT.p;
        },
        seed);
  EXPECT_GT((ends[0] - ends[1]).norm(), 1);
}

// What contact is computed from: each the derivative of the one before, by a second source.
TEST(DeckTest, VelocitiesAndAccelerationsAreTheDerivativesOfThePose) {
  DeckParameters p = Driving("circle", 3, 20);
  p.waves = WaveParameters{.spectrum = "bretschneider", .sea_state = 6, .from_deg = 60};
  Deck deck(p, Begin(), 3, 5, kStep_s);
  Pose X_NT = deck.now().X_NT;
  Eigen::Vector3d v_N = deck.now().v_N, w_N = deck.now().w_N;
  double tilt = 0, heave = 0;
  for (int i = 0; i < 5000; ++i) {  // the trapezium rule
    const DeckMotion before = deck.now();
    deck.Step();
    const DeckMotion& now = deck.now();
    X_NT.p += kStep_s * (before.v_N + now.v_N) / 2;
    X_NT.R = ExpRotation(kStep_s * (before.w_N + now.w_N) / 2) * X_NT.R;
    v_N += kStep_s * (before.a_N + now.a_N) / 2;
    w_N += kStep_s * (before.dw_N + now.dw_N) / 2;
    tilt = std::max(tilt, std::acos((now.X_NT.R * Eigen::Vector3d::UnitZ()).z()));
    heave = std::max(heave, std::abs(now.X_NT.p.z() + 1));
  }
  EXPECT_LT((X_NT.p - deck.now().X_NT.p).norm(), 1e-3);
  EXPECT_LT(LogRotation(X_NT.R.conjugate() * deck.now().X_NT.R).norm(), 1e-4);
  EXPECT_LT((v_N - deck.now().v_N).norm(), 0.01);
  EXPECT_LT((w_N - deck.now().w_N).norm(), 0.01);
  EXPECT_GT(Degrees(tilt), 1);
  EXPECT_GT(heave, 0.3);
}

std::string Refusals(const DeckParameters& deck) {
  Mistakes mistakes;
  CheckDeck(deck, 5, 2, Place("deck.yaml"), mistakes);
  std::string all;
  for (const Diagnostic& each : mistakes.all())
    all += each.key + ": " + each.what + "; " + each.remedy + "\n";
  return all;
}

TEST(DeckTest, RefusesADeckFasterThanTheAircraft) {
  EXPECT_EQ(Refusals(Driving("straight", 4)), "");
  EXPECT_THAT(Refusals(Driving("straight", 5)), HasSubstr("never comes up with it"));
  EXPECT_EQ(Refusals(Driving("circle", 4, 20)), "");
  EXPECT_THAT(Refusals(Driving("circle", 4, 5)), HasSubstr("deck.radius_m"));
}

TEST(DeckTest, RefusesWavesWithoutASpectrumOrAHeight) {
  const auto in = [](WaveParameters waves) {
    DeckParameters p;
    p.waves = waves;
    return Refusals(p);
  };
  EXPECT_EQ(in({.spectrum = "jonswap", .sea_state = 4}), "");
  EXPECT_EQ(in({.spectrum = "pierson_moskowitz", .height_m = 2}), "");
  EXPECT_THAT(in({.sea_state = 4}), HasSubstr("deck.waves.spectrum: none"));
  EXPECT_THAT(in({.spectrum = "jonswap"}), HasSubstr("deck.waves.height_m"));
  EXPECT_THAT(in({.spectrum = "jonswap", .height_m = 1}), HasSubstr("deck.waves.peak_s"));
  EXPECT_THAT(in({.spectrum = "pierson_moskowitz", .height_m = 1, .peak_s = 7}),
              HasSubstr("follows from its height"));
  EXPECT_THAT(in({.spectrum = "jonswap", .sea_state = 1}), HasSubstr("2 to 6"));
}

}  // namespace
}  // namespace kestrel::sim
