// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A fault of one sensor while t is in [from_s, until_s), in the vocabulary of PX4's failure injection. What
// the autopilot then hears of it:
//
//   off           nothing
//   stuck         at its own rate, the last reading from before; without one, the first
//   garbage       at its own rate, each component uniform in the sensor's range: see
//   sim/sensor/sensor_faults.h wrong         the reading and an offset: to rates, forces and field in B, to
//   the position and the
//                 velocity of a GPS in N, to the height of a barometer upwards
//   slow          rate_hz readings a second at most, beginning with the first
//   delayed       each reading delay_s after it was made; what is under way when the fault ends is lost
//   intermittent  of each period_s from from_s on, the readings of the first share of duty
//   ok            all: where this comes first in the list, no other fault of the sensor holds
//
// Of several faults of one sensor at a time the first in the list holds.
struct SensorFault {
  std::string component, type;
  double from_s = 0, until_s = 1e9;
  Eigen::Vector3d gyro_offset_deg_s{5, -5, 5};
  Eigen::Vector3d accelerometer_offset_m_s2{1, 0, 0};
  Eigen::Vector3d magnetometer_offset_ut{0, 15, 0};  // a heading wrong by 30 degrees towards north, in Madrid
  double barometer_offset_m = 10;
  Eigen::Vector3d gps_offset_m{10, 0, 0}, gps_offset_m_s{0, 0, 0};
  double rate_hz = 1;               // slow
  double delay_s = 0.5;             // delayed
  double period_s = 1, duty = 0.5;  // intermittent
  bool operator==(const SensorFault&) const = default;
};

inline void Fields(FieldVisitor& v, SensorFault& f) {
  v(Required("component",
             "the sensor that fails: gyro, accelerometer, magnetometer, barometer or GPS receiver"),
    f.component, {"gyro", "accel", "mag", "baro", "gps"});
  v(Required("type", "what becomes of its readings, in the vocabulary of PX4's failure injection"), f.type,
    {"off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent", "ok"});
  v({"from_s", "when the fault begins, in the time of the flight"}, f.from_s, 0.0, 1e9);
  v({"until_s", "when the fault ends"}, f.until_s, 0.0, 1e9);
  if (f.type == "wrong") {
    if (f.component == "gyro")
      v({"offset_deg_s", "what is added to the true rates, in B"}, f.gyro_offset_deg_s, -1000.0, 1000.0);
    if (f.component == "accel")
      v({"offset_m_s2", "what is added to the true specific force, in B"}, f.accelerometer_offset_m_s2,
        -200.0, 200.0);
    if (f.component == "mag")
      v({"offset_ut", "what is added to the true magnetic field, in B"}, f.magnetometer_offset_ut, -200.0,
        200.0);
    if (f.component == "baro")
      v({"offset_m", "what is added to the true height, upwards (baro), or to the true position, in N (gps)"},
        f.barometer_offset_m, -1e4, 1e4);
    if (f.component == "gps") {
      v({"offset_m", "what is added to the true height, upwards (baro), or to the true position, in N (gps)"},
        f.gps_offset_m, -1e4, 1e4);
      v({"offset_m_s", "what is added to the true velocity, in N"}, f.gps_offset_m_s, -500.0, 500.0);
    }
  }
  if (f.type == "slow")
    v({"rate_hz", "readings that still come in a second, at most"}, f.rate_hz, 0.01, 500.0);
  if (f.type == "delayed") v({"delay_s", "how much later each reading comes"}, f.delay_s, 0.001, 60.0);
  if (f.type == "intermittent") {
    v({"period_s", "length of a cycle, part of which has readings"}, f.period_s, 0.01, 3600.0);
    v({"duty", "share of each cycle, from its beginning, in which readings come"}, f.duty, 0.0, 1.0);
  }
}

// Whether a fault's time has come; times are multiples of a step, but for rounding.
template <class Fault>
bool IsOn(const Fault& fault, double t_s) {
  constexpr double kRounding_s = 1e-9;
  return t_s >= fault.from_s - kRounding_s && t_s < fault.until_s - kRounding_s;
}

// The one that holds of a sensor; none, or ok: nullptr.
inline const SensorFault* FaultAt(const std::vector<SensorFault>& faults, std::string_view component,
                                  double t_s) {
  for (const SensorFault& fault : faults)
    if (fault.component == component && IsOn(fault, t_s)) return fault.type == "ok" ? nullptr : &fault;
  return nullptr;
}

}  // namespace kestrel::sim
