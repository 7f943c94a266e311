// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/world/target.h"

// Random meetings of two or three aircraft in flight, built to pass near each other or harmlessly.
namespace kestrel::flight {

enum class EncounterKind { kHeadOn, kCrossing, kOvertaken, kTwoAtOnce };
const char* NameOf(EncounterKind kind);
inline constexpr int kEncounterKinds = 4;

struct EncounterPlan {
  EncounterKind kind = EncounterKind::kHeadOn;
  double own_speed_m_s = 1;
  double meets_s = 10;                         // closest, were everybody to go on
  double miss_m = 0;                           // how close, the first of them
  std::vector<sim::TargetParameters> targets;  // where they begin and how they fly
};

struct EncounterLimits {
  double radius_m = 1;  // R, of the sphere that holds each of them
  // They pass within these, of R: near ones by definition, harmless ones well off.
  double nearest = 0, farthest = 2;
};
inline constexpr EncounterLimits kNear{1, 0, 2}, kHarmless{1, 4, 12};

// One in four of each kind. We fly north from the origin of N at that height, at 1 to 5 m/s, and meet after 8
// to 12 s; others fly straight and level at 1 to 5 m/s: head-on within 20 degrees, crossing from 60 to 120
// degrees off either side, or ahead of us, at a fifth to half of our speed and within 20 degrees of our
// course. None comes from abaft the beam: such a one overtakes us, and by the rules of the air it gives way.
// Of two at once each is of the first two kinds, and they pass within 1.5 s of each other. The miss lies
// across the relative course, evenly in its length, level to half of it. looks: colour and diameter of each,
// at least two. acceleration: ours, from the beginning on.
EncounterPlan DrawEncounter(std::uint64_t seed, const EncounterLimits& limits, double height_m,
                            double acceleration_m_s2, const std::vector<sim::TargetParameters>& looks);

}  // namespace kestrel::flight
