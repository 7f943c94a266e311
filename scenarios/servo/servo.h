// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "base/yaml/fields.h"
#include "mission/mission_type.h"
#include "mission/servo/servo_laws.h"

namespace kestrel::scenarios {

struct ServoFlightGains {
  double lambda_per_s = 1.1;
  double integral_per_s = 0.2;
  double speed_limit_m_s = 1.5, climb_limit_m_s = 0.8, yaw_rate_limit_deg_s = 40;
};

inline void Fields(FieldVisitor& v, ServoFlightGains& g) {
  v({"lambda_per_s", "gain of the law: all its errors are to fall as exp(-lambda t)"}, g.lambda_per_s, 0.05,
    5.0);
  v({"integral_per_s",
     "gain of the integral of the law's velocity, which finds the error of the autopilot's; 0: none"},
    g.integral_per_s, 0.0, 2.0);
  v({"speed_limit_m_s", "maximum horizontal speed that is commanded"}, g.speed_limit_m_s, 0.05, 10.0);
  v({"climb_limit_m_s", "maximum vertical speed that is commanded, up or down"}, g.climb_limit_m_s, 0.05,
    5.0);
  v({"yaw_rate_limit_deg_s", "maximum yaw rate that is commanded"}, g.yaw_rate_limit_deg_s, 1.0, 180.0);
}

// Goes to where the pad is seen as it is wanted, by one law of visual servoing alone: no position and no
// filter. The law's velocity is scaled as a whole where a limit is met, so that the path stays its own.
struct ServoFlight {
  std::string law = "points_desired";
  double height_m = 3, yaw_deg = 0;
  double pad_tilt_deg = 0;
  bool level_camera = true;
  ServoFlightGains gains;
  double ceiling_m = 9, floor_m = 0.6;
  double give_up_s = 3;
};

inline void Fields(FieldVisitor& v, ServoFlight& p) {
  v({"law",
     "which law flies: points by the matrix that is current, desired, their mean, or current by depths from "
     "the own motion; bearings of points; 2 1/2-D; partitioned; the level image's moments; pose of the "
     "target "
     "(5.11), of the aircraft (5.13)"},
    p.law, mission::ServoLawNames());
  v({"height_m", "height above the middle of the pad from which the wanted image is seen"}, p.height_m, 0.5,
    60.0);
  v({"yaw_deg", "heading of the wanted image, clockwise from the top of the pad's picture"}, p.yaw_deg,
    -180.0, 180.0);
  v({"pad_tilt_deg", "how far the top of the pad is raised in the wanted image, as pad.tilt_deg has it"},
    p.pad_tilt_deg, 0.0, 60.0);
  v({"level_camera",
     "turn what is seen into the image of a level camera by the autopilot's roll and pitch; false: as it is "
     "seen"},
    p.level_camera);
  v({"gains", "gains and limits of the law"}, p.gains);
  v({"ceiling_m", "height above the pad at which the flight ends as retreated"}, p.ceiling_m, 1.0, 100.0);
  v({"floor_m", "height above the pad at which the flight ends as too low"}, p.floor_m, 0.2, 10.0);
  v({"give_up_s", "time without the pad after which the flight ends as lost"}, p.give_up_s, 0.1, 60.0);
}

mission::MissionType TypeOf(const ServoFlight& flight);
void CheckFlight(const ServoFlight& flight, const Place& where, Mistakes& mistakes);
void CheckFlightLimits(const ServoFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes);
void CheckFlightView(const ServoFlight& flight, const vision::CameraModel& camera,
                     const vision::CameraMount& mount, const Place& where, const Place& mount_where,
                     Mistakes& mistakes);
std::unique_ptr<mission::Mission> MakeMission(const ServoFlight& flight, const mission::MissionParts& parts);

}  // namespace kestrel::scenarios
