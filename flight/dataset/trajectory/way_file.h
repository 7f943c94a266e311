// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "flight/dataset/trajectory/trajectory.h"

namespace kestrel::flight {

// A place through which a way leads.
struct WayPoint {
  double t_s = 0;
  Eigen::Vector3d position_m{0, 0, 10};  // north and east of the origin of N, and height above the ground
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
};

// A way as a file gives it: a smooth curve through its places, each at its time.
struct WayFile {
  std::string look = "given";
  std::vector<WayPoint> way;
};

inline void Fields(FieldVisitor& v, WayPoint& p) {
  v(Required("t_s", "when the aircraft is there"), p.t_s, 0.0, 36000.0);
  v(Required("position_m",
             "north and east of the origin of N, and height of "
             "the aircraft above the ground"),
    p.position_m, -1e5, 1e5);
  v({"yaw_deg",
     "heading, clockwise from north; it turns by as much as is "
     "given, so 350 to 370 is 20 degrees"},
    p.yaw_deg, -36000.0, 36000.0);
  v({"pitch_deg", "pitch, nose up"}, p.pitch_deg, -89.0, 89.0);
  v({"roll_deg", "roll, right wing down"}, p.roll_deg, -36000.0, 36000.0);
}

inline void Fields(FieldVisitor& v, WayFile& w) {
  v({"look", "whether the heading is given, or along the way"}, w.look, {"given", "along"});
  v(Required("way", "places, one after the other, through which a cubic spline leads"), w.way);
}

// What a trajectory is made of, each piece with the line that it stands on.
struct LoadedTrajectory {
  Trajectory trajectory;
  std::vector<std::int64_t> stamps_ns;  // of its pieces
  std::vector<Place> places;
};

// Throws InputError with every mistake of the file.
LoadedTrajectory LoadWay(const std::filesystem::path& file);

}  // namespace kestrel::flight
