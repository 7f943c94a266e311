// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>

#include "base/yaml/fields.h"
#include "control/autopilot.h"

// The last word before a setpoint goes to a real aircraft. Flight code asks; this limits what it asks for,
// and where the ground for it is gone it does what is written down in kReactions, one row for each hazard,
// the first that applies. No row needs vision, and none sends a setpoint that is not finite.
namespace kestrel::control {

enum class Hazard {
  kPilot,       // his switch is not where it lets us fly
  kStateLost,   // nothing heard of the autopilot, or what is heard cannot be (Sane)
  kNotFinite,   // the setpoint
  kImageStale,  // the newest image is too old, or there is none yet
  kTargetLost,  // for longer than the flight code may look for it
  kOutside,     // the area
  kTooHigh,
  kNoSetpoint,  // the flight code asks for nothing
  kNone,
};

enum class Reaction {
  kSilence,  // nothing is sent: the aircraft is the pilot's, or the autopilot's by its own time-out
  kHold,     // velocity zero
  kSink,     // straight down, slowly, until the autopilot's touch-down logic stops the motors
  kReturn,   // level, slowly, towards the middle of the area
  kDescend,  // what was asked for, but down
  kFly,      // what was asked for, within the limits
};

struct ReactionRow {
  Hazard hazard;
  std::string_view when;
  Reaction first;
  Reaction later;  // once it has lasted for patience_s without a break
};

inline constexpr std::array kReactions{
    ReactionRow{Hazard::kPilot, "the pilot's switch is off, or unknown", Reaction::kSilence,
                Reaction::kSilence},
    ReactionRow{Hazard::kStateLost, "no sane state for state_s", Reaction::kHold, Reaction::kSilence},
    ReactionRow{Hazard::kNotFinite, "a setpoint is not finite", Reaction::kHold, Reaction::kSink},
    ReactionRow{Hazard::kImageStale, "no image for image_s", Reaction::kHold, Reaction::kSink},
    ReactionRow{Hazard::kTargetLost, "the target lost for target_s", Reaction::kHold, Reaction::kSink},
    ReactionRow{Hazard::kOutside, "farther than radius_m from the start", Reaction::kReturn,
                Reaction::kReturn},
    ReactionRow{Hazard::kTooHigh, "higher than height_m over the autopilot's origin", Reaction::kDescend,
                Reaction::kDescend},
    ReactionRow{Hazard::kNoSetpoint, "the flight code asks for nothing", Reaction::kHold, Reaction::kHold},
    ReactionRow{Hazard::kNone, "otherwise", Reaction::kFly, Reaction::kFly},
};

struct SafetyLimits {
  double speed_m_s = 2, climb_m_s = 1, yaw_rate_deg_s = 45, tilt_deg = 20;
  double thrust_min = 0.2, thrust_max = 0.8;
  double radius_m = 30, height_m = 20;
  double slow_m_s = 0.5;
  double state_s = 0.5, image_s = 0.5, target_s = 10;
  double patience_s = 10;
};

inline void Fields(FieldVisitor& v, SafetyLimits& l) {
  v({"speed_m_s", "maximum horizontal speed that is sent to the autopilot"}, l.speed_m_s, 0.1, 30.0);
  v({"climb_m_s", "maximum vertical speed, up or down, that is sent to the autopilot"}, l.climb_m_s, 0.1,
    10.0);
  v({"yaw_rate_deg_s", "maximum yaw rate that is sent to the autopilot"}, l.yaw_rate_deg_s, 1.0, 360.0);
  v({"tilt_deg", "maximum tilt from the vertical of an attitude setpoint"}, l.tilt_deg, 1.0, 60.0);
  v(Renamed("thrust_min", "thrust_least",
            "minimum thrust of an attitude setpoint, as a share of full thrust"),
    l.thrust_min, 0.0, 1.0);
  v(Renamed("thrust_max", "thrust_most", "maximum thrust of an attitude setpoint, as a share of full thrust"),
    l.thrust_max, 0.0, 1.0);
  v({"radius_m", "maximum horizontal distance from the start; beyond it the aircraft is flown back"},
    l.radius_m, 1.0, 5000.0);
  v({"height_m", "maximum height above the autopilot's local origin; above it the aircraft is brought down"},
    l.height_m, 0.5, 500.0);
  v({"slow_m_s", "speed of sinking, of returning into the area and of descending below its ceiling"},
    l.slow_m_s, 0.1, 2.0);
  v({"state_s", "age of the autopilot's state from which it counts as lost, and velocity zero is sent"},
    l.state_s, 0.05, 5.0);
  v({"image_s", "age of the newest image from which the camera counts as failed, and velocity zero is sent"},
    l.image_s, 0.05, 5.0);
  v({"target_s", "time without the target after which velocity zero is sent, whatever the mission asks for"},
    l.target_s, 0.1, 120.0);
  v({"patience_s",
     "time after which a failure that lasts is answered by more than holding: sinking, or silence"},
    l.patience_s, 0.5, 120.0);
}

// Ages in s, on our own monotonic clock, by which all of this is judged.
struct Situation {
  double t_s = 0;
  bool pilot_allows = false;
  VehicleState state;                                 // the last that was heard
  std::optional<double> state_age_s;                  // none: never heard
  std::optional<double> image_age_s;                  // none: never seen
  double target_lost_s = 0;                           // 0: in sight, or the flight has none
  std::optional<Setpoint> wanted;                     // by the flight code
  Eigen::Vector3d start_N = Eigen::Vector3d::Zero();  // the middle of the area, on the ground
};

struct SafetyState {
  Hazard hazard = Hazard::kNone;
  double since_s = 0;
};

struct SafeCommand {
  std::optional<Setpoint> setpoint;  // none: nothing is sent
  Reaction reaction = Reaction::kSilence;
  bool limited = false;  // what was asked for was more than is allowed
  SafetyState state;     // for the next call
};

SafeCommand MakeSafe(const Situation& now, const SafetyState& before, const SafetyLimits& limits);

const char* NameOf(Hazard hazard);      // "pilot", "state lost", ...
const char* NameOf(Reaction reaction);  // "silence", "hold", ...

}  // namespace kestrel::control
