// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "sim/camera/vibration.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::sim {

// A place on the way along which somebody carries the aircraft.
struct CarryPoint {
  double t_s = 0;
  Eigen::Vector3d position_m{0, 0, 1.5};  // north and east of the origin of N, and height above the ground
  double yaw_deg = 0;
};

// The aircraft in somebody's hands: its motors are off, and it does not fly.
struct CarryParameters {
  std::vector<CarryPoint> points;             // in the order of their times
  std::vector<vision::VibrationBand> tremor;  // of the hands
};

inline void Fields(FieldVisitor& v, CarryPoint& p) {
  v({"t_s", "when the aircraft rests there"}, p.t_s, 0.0, 36000.0);
  v({"position_m", "north and east of the origin of N, and height of the aircraft above the ground"},
    p.position_m, -300.0, 300.0);
  v({"yaw_deg", "its heading there, clockwise from north"}, p.yaw_deg, -360.0, 360.0);
}

inline void Fields(FieldVisitor& v, CarryParameters& p) {
  v({"points", "places to which the aircraft is carried, one after the other"}, p.points);
  v({"tremor", "bands of frequencies in which the hands tremble; none: they are still"}, p.tremor);
}

// What of a way cannot be gone: no places, times that do not rise, places in the ground.
void CheckCarry(const CarryParameters& parameters, const Place& where, Mistakes& mistakes);

// The way as a function of time alone. From each place the hand goes to the next as hands do, with the least
// jerk (T. Flash and N. Hogan, "The coordination of arm movements", J. Neuroscience 5(7), 1985): the quintic
// that begins and ends at rest. Before the first place and after the last it stays there.
class CarriedPath {
 public:
  // parameters: with one place at least.
  CarriedPath(const CarryParameters& parameters, std::uint64_t seed);

  Pose X_NB(double t_s) const;

 private:
  std::vector<CarryPoint> points_;
  Vibration tremor_;
};

}  // namespace kestrel::sim
