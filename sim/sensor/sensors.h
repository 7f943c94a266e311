// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/random.h"
#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "sim/sensor/attitude_fault.h"
#include "sim/sensor/sensor_fault.h"

namespace kestrel::sim {

// A slow wander (first-order Gauss-Markov) with white noise on top.
struct SensorError {
  double white = 0;   // standard deviation of one sample
  double wander = 0;  // stationary deviation of the slow part
  double wander_time_s = 100;
};

struct SensorParameters {
  // ADIS16448 as modelled in RotorS
  double gyro_noise_rad_s_rthz = 3.394e-4;
  double gyro_walk_rad_s2_rthz = 3.8785e-5;
  double gyro_walk_time_s = 1000;
  double gyro_turn_on_rad_s = 0.0087;
  double accelerometer_noise_m_s2_rthz = 0.004;
  double accelerometer_walk_m_s3_rthz = 0.006;
  double accelerometer_walk_time_s = 300;
  double accelerometer_turn_on_m_s2 = 0.196;

  double gps_rate_hz = 5;  // AscTec: a packet every 200 ms
  SensorError gps_horizontal_m{0.05, 2.1,
                               1100};  // u-blox 6: 2.5 m half inside; time by Rankin; white part assumed
  SensorError gps_vertical_m{0.1, 3.5, 1100};   // worse than level by the usual 1.7
  SensorError gps_velocity_m_s{0.1, 0.03, 30};  // u-blox 6: 0.1 m/s; wander assumed
  double barometer_rate_hz = 25;
  SensorError barometer_m{0.1, 0.5, 300};  // assumed: no figure of the AscTec's is published
  double magnetometer_rate_hz = 25;
  double magnetometer_white_t = 80e-9;     // RotorS
  double magnetometer_turn_on_t = 400e-9;  // RotorS
  std::vector<AttitudeFault> attitude_faults;
  std::vector<SensorFault> faults;
};

inline void Fields(FieldVisitor& v, SensorError& e) {
  v({"white", "standard deviation of the white noise of one reading"}, e.white, 0.0, 100.0);
  v({"wander", "standard deviation of the slow error (first-order Gauss-Markov)"}, e.wander, 0.0, 100.0);
  v({"wander_time_s", "correlation time of the slow error"}, e.wander_time_s, 0.1, 1e5);
}

inline void Fields(FieldVisitor& v, SensorParameters& p) {
  v({"gyro_noise_rad_s_rthz", "noise density of the rate gyros, rad/s per root hertz"},
    p.gyro_noise_rad_s_rthz, 0.0, 0.1);
  v({"gyro_walk_rad_s2_rthz", "density of the random walk of the gyros' bias"}, p.gyro_walk_rad_s2_rthz, 0.0,
    0.1);
  v({"gyro_walk_time_s", "correlation time of the gyros' bias"}, p.gyro_walk_time_s, 1.0, 1e6);
  v({"gyro_turn_on_rad_s", "standard deviation of the gyros' bias at switch-on"}, p.gyro_turn_on_rad_s, 0.0,
    0.5);
  v({"accelerometer_noise_m_s2_rthz", "noise density of the accelerometers, m/s^2 per root hertz"},
    p.accelerometer_noise_m_s2_rthz, 0.0, 1.0);
  v({"accelerometer_walk_m_s3_rthz", "density of the random walk of the accelerometers' bias"},
    p.accelerometer_walk_m_s3_rthz, 0.0, 1.0);
  v({"accelerometer_walk_time_s", "correlation time of the accelerometers' bias"},
    p.accelerometer_walk_time_s, 1.0, 1e6);
  v({"accelerometer_turn_on_m_s2", "standard deviation of the accelerometers' bias at switch-on"},
    p.accelerometer_turn_on_m_s2, 0.0, 2.0);
  v({"gps_rate_hz", "fixes of the GPS receiver in a second"}, p.gps_rate_hz, 0.1, 50.0);
  v({"gps_horizontal_m", "error of the GPS position, of north and east each"}, p.gps_horizontal_m);
  v({"gps_vertical_m", "error of the GPS height"}, p.gps_vertical_m);
  v({"gps_velocity_m_s", "error of the GPS velocity, of each component"}, p.gps_velocity_m_s);
  v({"barometer_rate_hz", "readings of the barometer in a second"}, p.barometer_rate_hz, 0.1, 500.0);
  v({"barometer_m", "error of the barometric height"}, p.barometer_m);
  v({"magnetometer_rate_hz", "readings of the magnetometer in a second"}, p.magnetometer_rate_hz, 0.1, 500.0);
  v({"magnetometer_white_t", "standard deviation of the magnetometer's white noise, tesla"},
    p.magnetometer_white_t, 0.0, 1e-4);
  v({"magnetometer_turn_on_t", "standard deviation of the magnetometer's bias at switch-on, tesla"},
    p.magnetometer_turn_on_t, 0.0, 1e-4);
  v({"attitude_faults",
     "faults of the attitude that the autopilot has from its own sensors; the first that is on holds"},
    p.attitude_faults);
  v({"faults", "faults of single sensors; of several of one sensor at a time the first in the list holds"},
    p.faults);
}

struct ImuSample {
  Eigen::Vector3d w_B;               // rad/s
  Eigen::Vector3d specific_force_B;  // m/s^2; at rest and level (0, 0, -g)
};

struct GpsSample {
  Eigen::Vector3d p_N, v_N;
};

// What the sensors said in one step of the simulation; the slow ones speak now and then.
struct SensorReadings {
  ImuSample imu;
  bool gyro_spoke = true, accelerometer_spoke = true;  // otherwise imu has what they said last
  std::optional<GpsSample> gps;
  std::optional<double> height_m;          // of the barometer, above the origin of N
  std::optional<Eigen::Vector3d> field_B;  // magnetometer, T
  double rotor_rad_s = 0;                  // tachometer of a helicopter's main rotor
};

// The earth's magnetic field in N, T: Madrid, 44.5 uT with a dip of 55 degrees; declination left out, so that
// magnetic north is north.
Eigen::Vector3d EarthField_N();

// The sensors of an autopilot: truth in, readings with their errors out. GPS and barometer are referred to
// where and when the autopilot was switched on, so their wander starts at zero.
class Sensors {
 public:
  Sensors(const SensorParameters& parameters, std::uint64_t seed);

  // Truth over the last step: the aircraft's pose and velocity at its end, its angular rate and specific
  // force in B.
  SensorReadings Read(double dt_s, const Pose& X_NB, const Eigen::Vector3d& v_N, const Eigen::Vector3d& w_B,
                      const Eigen::Vector3d& specific_force_B);

 private:
  struct Wander {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    void Step(double dt_s, double sigma, double time_s, RandomStream& random);
  };

  SensorParameters parameters_;
  RandomStream imu_random_, gps_random_, barometer_random_, magnetometer_random_;
  Eigen::Vector3d gyro_turn_on_, accelerometer_turn_on_, magnetometer_turn_on_;
  Wander gyro_, accelerometer_, gps_horizontal_, gps_vertical_, gps_velocity_, barometer_;
  std::int64_t steps_ = 0;
};

}  // namespace kestrel::sim
