// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "base/yaml/fields.h"
#include "sim/sensor/sensors.h"

// Instruments that an aircraft carries beside the sensors of its autopilot, for whoever records or estimates:
// they steer nothing.
namespace kestrel::sim {

// When an instrument measures, and when its readings come.
struct SampleTiming {
  double phase_s = 0;         // of the first reading, in the time of the flight
  double latency_s = 0;       // from the instant that a reading is of until it has come
  double clock_offset_s = 0;  // what its own clock shows more than the flight's
};

// White noise and a bias that walks, as Kalibr has them.
struct ImuParameters : SampleTiming {
  std::string file;  // imu.yaml of Kalibr; empty: none
  double rate_hz = 200;
  double accelerometer_noise_density = 0.004;  // ADIS16448 as modelled in RotorS
  double accelerometer_random_walk = 0.006;
  double accelerometer_turn_on_m_s2 = 0.196;
  double gyroscope_noise_density = 3.394e-4;
  double gyroscope_random_walk = 3.8785e-5;
  double gyroscope_turn_on_rad_s = 0.0087;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // of I in B
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;       // R_BI = Rz(yaw) Ry(pitch) Rx(roll)
};

struct GpsParameters : SampleTiming {
  double rate_hz = 5;
  SensorError horizontal_m{0.05, 2.1, 1100};  // as the autopilot's own, see sim/sensor/sensors.h
  SensorError vertical_m{0.1, 3.5, 1100};
  SensorError velocity_m_s{0.1, 0.03, 30};
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

struct BarometerParameters : SampleTiming {
  double rate_hz = 25;
  SensorError height_m{0.1, 0.5, 300};
};

struct MagnetometerParameters : SampleTiming {
  double rate_hz = 25;
  double white_t = 80e-9;     // RotorS
  double turn_on_t = 400e-9;  // RotorS
};

struct RangefinderParameters : SampleTiming {
  double rate_hz = 50;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction{0, 0, 1};
  double min_m = 0.2, max_m = 40;  // of a small laser, Lightware's SF11 or Garmin's LIDAR-Lite
  double noise_m = 0.02;
};

struct InstrumentParameters {
  std::optional<ImuParameters> imu = {};
  std::optional<GpsParameters> gps = {};
  std::optional<BarometerParameters> barometer = {};
  std::optional<MagnetometerParameters> magnetometer = {};
  std::optional<RangefinderParameters> rangefinder = {};

  bool any() const { return imu || gps || barometer || magnetometer || rangefinder; }
};

inline void Fields(FieldVisitor& v, SampleTiming& t) {
  v({"phase_s", "when the first reading is made, in the time of the flight"}, t.phase_s, 0.0, 10.0);
  v({"latency_s", "time from the instant that a reading is of until it has come"}, t.latency_s, 0.0, 2.0);
  v({"clock_offset_s", "what its own clock, and so its stamps, show more than the flight's"},
    t.clock_offset_s, -10.0, 10.0);
}

inline void Fields(FieldVisitor& v, ImuParameters& p) {
  v({"file",
     "imu.yaml of Kalibr, whose noise densities, random walks and update rate hold where the keys are not "
     "given; empty: none"},
    p.file);
  v({"rate_hz", "readings in a second"}, p.rate_hz, 1.0, 1000.0);
  Fields(v, static_cast<SampleTiming&>(p));
  v({"accelerometer_noise_density", "noise density of the accelerometers, m/s^2 per root hertz"},
    p.accelerometer_noise_density, 0.0, 1.0);
  v({"accelerometer_random_walk", "density of the random walk of their bias, m/s^3 per root hertz"},
    p.accelerometer_random_walk, 0.0, 1.0);
  v({"accelerometer_turn_on_m_s2", "standard deviation of their bias at the beginning"},
    p.accelerometer_turn_on_m_s2, 0.0, 5.0);
  v({"gyroscope_noise_density", "noise density of the rate gyros, rad/s per root hertz"},
    p.gyroscope_noise_density, 0.0, 0.1);
  v({"gyroscope_random_walk", "density of the random walk of their bias, rad/s^2 per root hertz"},
    p.gyroscope_random_walk, 0.0, 0.1);
  v({"gyroscope_turn_on_rad_s", "standard deviation of their bias at the beginning"},
    p.gyroscope_turn_on_rad_s, 0.0, 0.5);
  v({"position_m", "position on the aircraft: forward, right, down of its centre of mass"}, p.position_m,
    -2.0, 2.0);
  v({"yaw_deg", "turn about the aircraft's z (down), from axes forward, right, down"}, p.yaw_deg, -180.0,
    180.0);
  v({"pitch_deg", "then about its own y"}, p.pitch_deg, -90.0, 90.0);
  v({"roll_deg", "then about its own x; 180 gives axes forward, left, up"}, p.roll_deg, -180.0, 180.0);
}

inline void Fields(FieldVisitor& v, GpsParameters& p) {
  v({"rate_hz", "fixes in a second"}, p.rate_hz, 0.1, 50.0);
  Fields(v, static_cast<SampleTiming&>(p));
  v({"horizontal_m", "error of the position, of north and east each"}, p.horizontal_m);
  v({"vertical_m", "error of the height"}, p.vertical_m);
  v({"velocity_m_s", "error of each component of the velocity"}, p.velocity_m_s);
  v({"position_m", "position of the antenna on the aircraft: forward, right, down"}, p.position_m, -2.0, 2.0);
}

inline void Fields(FieldVisitor& v, BarometerParameters& p) {
  v({"rate_hz", "readings in a second"}, p.rate_hz, 0.1, 500.0);
  Fields(v, static_cast<SampleTiming&>(p));
  v({"height_m", "error of the height"}, p.height_m);
}

inline void Fields(FieldVisitor& v, MagnetometerParameters& p) {
  v({"rate_hz", "readings in a second"}, p.rate_hz, 0.1, 500.0);
  Fields(v, static_cast<SampleTiming&>(p));
  v({"white_t", "standard deviation of the white noise, tesla"}, p.white_t, 0.0, 1e-4);
  v({"turn_on_t", "standard deviation of the bias, tesla"}, p.turn_on_t, 0.0, 1e-4);
}

inline void Fields(FieldVisitor& v, RangefinderParameters& p) {
  v({"rate_hz", "readings in a second"}, p.rate_hz, 0.1, 1000.0);
  Fields(v, static_cast<SampleTiming&>(p));
  v({"position_m", "position on the aircraft: forward, right, down"}, p.position_m, -2.0, 2.0);
  v({"direction", "direction of the beam in the axes of the aircraft, of any length: forward, right, down"},
    p.direction, -1.0, 1.0);
  v({"min_m", "shortest range that is measured"}, p.min_m, 0.0, 1000.0);
  v({"max_m", "longest range that is measured"}, p.max_m, 0.01, 10000.0);
  v({"noise_m", "standard deviation of the white noise"}, p.noise_m, 0.0, 10.0);
}

inline void Fields(FieldVisitor& v, InstrumentParameters& p) {
  v({"imu", "inertial measurement unit; null: none"}, p.imu);
  v({"gps", "GPS receiver; null: none"}, p.gps);
  v({"barometer", "barometer; null: none"}, p.barometer);
  v({"magnetometer", "magnetometer; null: none"}, p.magnetometer);
  v({"rangefinder", "rangefinder, such as a laser altimeter; null: none"}, p.rangefinder);
}

}  // namespace kestrel::sim
