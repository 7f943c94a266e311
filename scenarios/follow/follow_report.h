// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "control/law/sphere_target.h"
#include "mission/decision.h"

namespace kestrel::scenarios {

// A balloon as a level camera that looks straight ahead would have it now, beside what is wanted of it.
struct BalloonSight {
  control::SphereImage now, wanted;
  double focal_px = 1;  // of that camera
};

struct FollowReport final : mission::MissionReport {
  BalloonSight sight;
};

// Null while no balloon is followed.
inline const BalloonSight* SightOf(const mission::Decision& decision) {
  const auto* report = mission::ReportOf<FollowReport>(decision);
  return report ? &report->sight : nullptr;
}

}  // namespace kestrel::scenarios
