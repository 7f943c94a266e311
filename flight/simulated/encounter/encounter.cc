// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/encounter/encounter.h"

#include <cmath>

#include "base/random.h"
#include "geometry/tait_bryan.h"

namespace kestrel::flight {
namespace {

constexpr double kObeys_s = 0.4;  // the aircraft takes to do what it is told

// Where and how fast another flies that meets us, who are at p_own at t_s, north at own_speed.
sim::TargetParameters Draw(RandomStream& random, EncounterKind kind, double own_speed,
                           const Eigen::Vector3d& p_own, double t_s, const EncounterLimits& limits,
                           sim::TargetParameters look, double& miss_m) {
  Eigen::Vector3d v;  // north, east, up
  Eigen::Vector2d relative;
  do {
    const double side = random.Uniform(-1, 1) < 0 ? -1 : 1;
    double speed = random.Uniform(1, 5), course_deg = 180 + random.Uniform(-20, 20);
    if (kind == EncounterKind::kCrossing) course_deg = side * random.Uniform(60, 120);
    if (kind == EncounterKind::kOvertaken)
      course_deg = random.Uniform(-20, 20), speed = random.Uniform(0.2, 0.5) * own_speed;
    v = {speed * std::cos(Radians(course_deg)), speed * std::sin(Radians(course_deg)), 0};
    relative = v.head<2>() - Eigen::Vector2d(own_speed, 0);
  } while (relative.x() > 0);  // it comes from abaft the beam
  const Eigen::Vector2d across = Eigen::Vector2d(-relative.y(), relative.x()).normalized();
  miss_m = limits.radius_m * random.Uniform(limits.nearest, limits.farthest);
  const double up = random.Uniform(-0.5, 0.5);
  const double level = (random.Uniform(-1, 1) < 0 ? -1 : 1) * std::sqrt(1 - up * up);
  const Eigen::Vector3d miss = miss_m * Eigen::Vector3d(level * across.x(), level * across.y(), up);
  look.position_m = p_own + miss - t_s * v;
  look.velocity_m_s = v;
  look.string_m = look.roam_m_s = 0;
  return look;
}

}  // namespace

const char* NameOf(EncounterKind kind) {
  switch (kind) {
    case EncounterKind::kHeadOn:
      return "head-on";
    case EncounterKind::kCrossing:
      return "crossing";
    case EncounterKind::kOvertaken:
      return "overtaken";
    case EncounterKind::kTwoAtOnce:
      return "two at once";
  }
  return "";
}

EncounterPlan DrawEncounter(std::uint64_t seed, const EncounterLimits& limits, double height_m,
                            double acceleration_m_s2, const std::vector<sim::TargetParameters>& looks) {
  RandomStream random(seed, "encounter");
  EncounterPlan plan;
  plan.kind = static_cast<EncounterKind>(random.Bits() % kEncounterKinds);
  plan.own_speed_m_s = random.Uniform(1, 5);
  plan.meets_s = random.Uniform(8, 12);
  const auto own = [&](double t_s) {
    const double lost_s = kObeys_s + plan.own_speed_m_s / (2 * acceleration_m_s2);  // on the way up to speed
    return Eigen::Vector3d(plan.own_speed_m_s * (t_s - lost_s), 0, height_m);
  };
  const auto add = [&](EncounterKind kind, double t_s, double& miss_m) {
    plan.targets.push_back(
        Draw(random, kind, plan.own_speed_m_s, own(t_s), t_s, limits, looks[plan.targets.size()], miss_m));
  };
  if (plan.kind != EncounterKind::kTwoAtOnce) {
    add(plan.kind, plan.meets_s, plan.miss_m);
    return plan;
  }
  const auto either = [&] {
    return random.Uniform(-1, 1) < 0 ? EncounterKind::kHeadOn : EncounterKind::kCrossing;
  };
  double second_miss_m = 0;
  add(either(), plan.meets_s, plan.miss_m);
  add(either(), plan.meets_s + random.Uniform(-1.5, 1.5), second_miss_m);
  return plan;
}

}  // namespace kestrel::flight
