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
#include "vision/camera/camera_model.h"

namespace kestrel::scenarios {

// Thesis 6.4: on the way along a straight course the aircraft sees others by the coloured marks that they
// carry or by their contrast with the sky, passes them at a bearing that it holds them at (6.29), and returns
// to its course: what the thesis left open.
struct AvoidFlight {
  double speed_m_s = 0.5;
  double course_m = 20;     // straight ahead from where the flight begins
  bool avoids = true;       // false: it flies on whatever it sees
  double memory_s = 8;      // who has not been seen for longer is forgotten
  double confirm_s = 0.25;  // a threat must last for so long before anything is done
  // Of the distance that the least bearing allows from where a manoeuvre begins: kept on the way past and
  // back. 0: safe_m alone counts.
  double keep_share = 0;
  double cross_track_gain_per_s = 0.5;
  std::vector<mission::BalloonObserverParameters> marks{mission::BalloonObserverParameters{}};
  std::optional<ContrastObserverParameters> contrast;  // none: marks alone are looked for
  control::AvoidanceOptions avoidance;
};

inline void Fields(FieldVisitor& v, AvoidFlight& p) {
  v("speed_m_s", p.speed_m_s, 0.1, 15.0);
  v("course_m", p.course_m, 1.0, 5000.0);
  v("avoids", p.avoids);
  v("memory_s", p.memory_s, 0.3, 60.0);
  v("confirm_s", p.confirm_s, 0.0, 5.0);
  v("keep_share", p.keep_share, 0.0, 1.0);
  v("cross_track_gain_per_s", p.cross_track_gain_per_s, 0.05, 2.0);
  v("marks", p.marks);
  v("contrast", p.contrast);
  v("avoidance", p.avoidance);
}

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
