// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "control/law/avoidance.h"
#include "geometry/pose.h"
#include "mission/balloon_observer.h"
#include "mission/mission_type.h"
#include "scenarios/avoid/contrast_observer.h"
#include "scenarios/avoid/growth_judge.h"
#include "vision/camera/camera_model.h"

namespace kestrel::scenarios {

// Thesis 6.4: on the way along a straight course the aircraft sees others by the coloured marks that they
// carry or by their contrast with the sky, passes them at a bearing that it holds them at (6.29), and returns
// to its course: what the thesis left open. When to begin and to end it decides by the range, which needs marks
// of known size, or without any range by growth and bearing rate; or it does what the thesis did.
struct AvoidFlight {
  std::string decides_by = "range";
  double end_s = 20;
  double speed_m_s = 0.5;
  double course_m = 20;
  bool avoids = true;
  double memory_s = 8;
  double confirm_s = 0.25;
  double keep_share = 0;  // of what the least bearing allows from where a manoeuvre begins
  double cross_track_gain_per_s = 0.5;
  std::vector<mission::BalloonObserverParameters> marks{mission::BalloonObserverParameters{}};
  std::optional<ContrastObserverParameters> contrast;
  control::AvoidanceOptions avoidance;
  GrowthOptions growth;
};

inline void Fields(FieldVisitor& v, AvoidFlight& p) {
  v({"decides_by",
     "what begins and ends a manoeuvre: range; growth: of the angle, with the rate of the bearing, without "
     "any "
     "range; sight: it begins at once and ends by hand, as in the thesis"},
    p.decides_by, {"range", "growth", "sight"});
  v({"end_s", "time at which the flight is ended by hand if it decides by sight"}, p.end_s, 1.0, 3600.0);
  v({"speed_m_s", "speed that is flown, kept in manoeuvres too"}, p.speed_m_s, 0.1, 15.0);
  v({"course_m", "length of the course, straight ahead from where the flight begins"}, p.course_m, 1.0,
    5000.0);
  v({"avoids", "avoid other aircraft; false: fly on whatever is seen"}, p.avoids);
  v({"memory_s", "time without being seen after which another aircraft is forgotten"}, p.memory_s, 0.3, 60.0);
  v({"confirm_s", "time for which a threat must last before a manoeuvre begins, or be gone before it ends"},
    p.confirm_s, 0.0, 5.0);
  v({"keep_share",
     "share of the passing distance possible with hold.bearing_deg that is kept past and back; 0: safe_m "
     "alone"},
    p.keep_share, 0.0, 1.0);
  v({"cross_track_gain_per_s", "proportional gain from cross-track error to the velocity back to the course"},
    p.cross_track_gain_per_s, 0.05, 2.0);
  v({"marks", "coloured marks of known size by which other aircraft are seen"}, p.marks);
  v({"contrast", "detection of other aircraft by their contrast with the sky; not given: by marks alone"},
    p.contrast);
  v({"avoidance", "when another aircraft is avoided, and at which bearing it is held"}, p.avoidance);
  v({"growth", "what is a threat, and how far it is turned off, without a range"}, p.growth);
}

// The height at the beginning is held.
constexpr double kHeightGain_per_s = 0.8, kClimbLimit_m_s = 1;

mission::MissionType TypeOf(const AvoidFlight& flight);
void CheckFlight(const AvoidFlight& flight, const Place& where, Mistakes& mistakes);
void CheckFlightLimits(const AvoidFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes);
void CheckFlightView(const AvoidFlight& flight, const vision::CameraModel& camera,
                     const vision::CameraMount& mount, const Place& where, const Place& mount_where,
                     Mistakes& mistakes);
bool FlightCanHave(const AvoidFlight& flight, const std::string& metric, const mission::Varies& varies);
std::unique_ptr<mission::Mission> MakeMission(const AvoidFlight& flight, const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
