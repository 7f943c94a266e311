// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "control/autopilot.h"
#include "control/estimate/velocity_lag.h"
#include "control/law/sphere_target.h"
#include "vision/camera.h"

namespace kestrel {

// Where the aircraft is by what the camera saw at the exposure of the frame, and how far to trust it.
struct TargetFix {
  Eigen::Vector3d p_TB = Eigen::Vector3d::Zero();  // m, the aircraft in the target's frame
  double yaw_TB = 0;                               // rad
  int inliers = 0;                                 // point pairs that agree
  double residual_px = 0;                          // their root mean square error
  double visible = 0;                              // share of the target that was matched, 0 to 1
  bool registered = false;                         // against the reference appearance, so free of drift
};

// What one image says of the attitude, before any filter.
struct AttitudeFix {
  double roll = 0, pitch = 0;              // rad
  double roll_sigma = 0, pitch_sigma = 0;  // rad, as the measurement itself states them
  std::optional<double> turned;            // rad, clockwise since the first image, over any number of turns
  double turned_sigma = 0;                 // rad
};

// A balloon as a level camera that looks straight ahead would have it now, beside what is wanted of it.
struct BalloonSight {
  SphereImage now, wanted;
  double focal_px = 1;  // of that camera
};

// Another aircraft that was seen, as the flight code has it.
struct Encounter {
  double azimuth = 0;            // in the heading frame, right positive, rad
  std::optional<double> wanted;  // the bearing at which it is held, rad; none: nothing need be done
  double range_m = 0;
  double miss_m = 0, after_s = 0;  // the closest distance if both go on, and when
};

// Whether a flight needs to see its target to stay in the air: what the safety layer of a real aircraft is to
// hold it to (control/safety/safety.h).
enum class TargetNeed {
  kUndeclared,  // nobody has said: such a mission is not flown on a real aircraft
  kNone,        // what it commands is safe whatever the camera shows, or the mission itself stops when blind
  kInSight,     // it flies by what it sees; lost for too long, the safety layer holds, then sinks
};

// What the flight code decided on one frame.
struct Decision {
  std::optional<Setpoint> setpoint;  // none: the last one stands until it is stale
  std::string_view phase;            // of the flight plan: "search", "centre", "descend", ...
  std::string_view target;  // "tracked", "found" (in this frame), "chained", "refused" (seen where it cannot
                            // be), "lost", "frozen" (the image repeats itself); of an attitude "horizon",
                            // or the reason why there is none; of a balloon its TrackState
  bool target_in_sight = false;  // in this frame, to be flown by; of a mission that needs it (TargetNeed)
  std::optional<TargetFix> fix;  // none while the target is lost
  double fix_age_s = 0;          // time since the exposure of the newest fix; grows while lost
  std::optional<AttitudeFix> attitude;
  std::optional<double> coasting_s;       // for how long the gyros alone have carried the camera's attitude
  std::optional<AttitudeAid> aid;         // for the autopilot to fly by in place of its own attitude
  std::optional<AttitudeFix> baseline;    // the thesis's own way, where both are compared
  std::optional<BalloonSight> sight;      // none while no balloon is followed
  std::optional<Encounter> encounter;     // the other that matters most; none in sight
  std::optional<Eigen::Vector3d> goal_T;  // where the aircraft is meant to be, in the target's frame, m
  double goal_yaw_TB = 0;                 // the yaw that goes with it, rad
  std::string_view outcome;               // not empty: the flight is over, and this is how
  double vision_s = 0;                    // time spent on the image; the mission measures it
  double control_s = 0;                   // the rest of the step; the flight loop measures it
};

// A flight's own code: vision pipeline and control law with their state. It sees frames and the autopilot's
// estimate, never the simulator, its truth or a clock. For a real aircraft it must declare Target(), and
// where that is kInSight tell with each decision whether it is.
class Mission {
 public:
  virtual ~Mission() = default;
  virtual Decision Step(const Frame& frame, const VehicleState& state) = 0;
  // Whether the flight, were it to end now, has done what it is for.
  virtual bool Accomplished() const { return true; }
  virtual TargetNeed Target() const { return TargetNeed::kUndeclared; }
  // How late an autopilot may follow the velocities that it is given; endless: they close no loop by sight,
  // or nothing is known of it.
  virtual VelocityLag MostLag() const { return {}; }
  // Draws what the vision code saw in the last frame on a colour copy of it.
  virtual void Draw(cv::Mat& bgr) const = 0;
};

}  // namespace kestrel
