// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string_view>

#include "control/autopilot.h"

namespace kestrel::mission {

// Where the aircraft is by what the camera saw at the exposure of the frame, and how far to trust it.
struct TargetFix {
  Eigen::Vector3d p_TB = Eigen::Vector3d::Zero();  // m, the aircraft in the target's frame
  double yaw_TB = 0;                               // rad
  int inliers = 0;                                 // point pairs that agree
  double residual_px = 0;                          // their root mean square error
  double visible = 0;                              // share of the target that was matched, 0 to 1
  bool registered = false;                         // against the reference appearance, so free of drift
};

// The state of a mission's target in one frame.
enum class TargetState {
  kNone,       // the mission has no target
  kInSight,    // measured in this frame, to be flown by
  kUncertain,  // something was seen that is not to be flown by: ambiguous, implausible, too close
  kLost,       // not seen
  kBlind,      // the image shows nothing: frozen or blank
};
const char* NameOf(TargetState state);

// What a mission has to say of a frame beyond what all have, in a type of its own: for the telemetry, the
// metrics and the plots that it declares (mission/mission_type.h).
struct MissionReport {
  virtual ~MissionReport() = default;
};

// What the flight code decided on one frame.
struct Decision {
  std::optional<control::Setpoint> setpoint;  // none: the last one stands until it is stale
  std::optional<control::AttitudeAid> aid;    // for the autopilot to fly by in place of its own attitude
  std::string_view phase;                     // of the flight plan: "search", "centre", "descend", ...
  TargetState target_state = TargetState::kNone;
  std::string_view target;       // the same in the mission's own word: "tracked", "chained", "frozen"
  std::optional<TargetFix> fix;  // none while the target is lost
  double fix_age_s = 0;          // time since the exposure of the newest fix; grows while lost
  std::optional<Eigen::Vector3d> goal_T;  // where the aircraft is meant to be, in the target's frame, m
  double goal_yaw_TB = 0;                 // the yaw that goes with it, rad
  std::shared_ptr<const MissionReport> report;
  std::string_view outcome;  // not empty: the flight is over, and this is how
  double vision_s = 0;       // time spent on the image; the mission measures it
  double control_s = 0;      // the rest of the step; the flight loop measures it
};

// A mission's own report; null: there is none, or it is another mission's.
template <class Report>
const Report* ReportOf(const Decision& decision) {
  return dynamic_cast<const Report*>(decision.report.get());
}

}  // namespace kestrel::mission
