// SPDX-License-Identifier: Apache-2.0
#include "sim/sensor/sensors.h"

#include <cmath>
#include <numbers>

namespace kestrel::sim {
namespace {

Eigen::Vector3d Normal3(RandomStream& random) {
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  return {x, y, z};
}

// Whether a sensor of this rate speaks in the step that ends at steps * dt.
bool Due(std::int64_t steps, double dt_s, double rate_hz) {
  return std::floor(static_cast<double>(steps) * dt_s * rate_hz + 1e-9) >
         std::floor(static_cast<double>(steps - 1) * dt_s * rate_hz + 1e-9);
}

}  // namespace

Eigen::Vector3d EarthField_N() {
  constexpr double kDip = 55 * std::numbers::pi / 180, kField_t = 44.5e-6;
  return {kField_t * std::cos(kDip), 0, kField_t * std::sin(kDip)};
}

void Sensors::Wander::Step(double dt_s, double sigma, double time_s, RandomStream& random) {
  const double keep = std::exp(-dt_s / time_s);  // exact for any step
  value = keep * value + sigma * std::sqrt(1 - keep * keep) * Normal3(random);
}

Sensors::Sensors(const SensorParameters& parameters, std::uint64_t seed)
    : parameters_(parameters),
      imu_random_(seed, "imu"),
      gps_random_(seed, "gps"),
      barometer_random_(seed, "barometer"),
      magnetometer_random_(seed, "magnetometer"),
      gyro_turn_on_(parameters.gyro_turn_on_rad_s * Normal3(imu_random_)),
      accelerometer_turn_on_(parameters.accelerometer_turn_on_m_s2 * Normal3(imu_random_)),
      magnetometer_turn_on_(parameters.magnetometer_turn_on_t * Normal3(magnetometer_random_)) {}

SensorReadings Sensors::Read(double dt_s, const Pose& X_NB, const Eigen::Vector3d& v_N,
                             const Eigen::Vector3d& w_B, const Eigen::Vector3d& specific_force_B) {
  ++steps_;
  const SensorParameters& p = parameters_;
  // A walk of density k that is pulled back with time T has the stationary deviation k sqrt(T / 2).
  gyro_.Step(dt_s, p.gyro_walk_rad_s2_rthz * std::sqrt(p.gyro_walk_time_s / 2), p.gyro_walk_time_s,
             imu_random_);
  accelerometer_.Step(dt_s, p.accelerometer_walk_m_s3_rthz * std::sqrt(p.accelerometer_walk_time_s / 2),
                      p.accelerometer_walk_time_s, imu_random_);
  const double root_rate = std::sqrt(1 / dt_s);

  SensorReadings r;
  r.imu.w_B = w_B + gyro_turn_on_ + gyro_.value + p.gyro_noise_rad_s_rthz * root_rate * Normal3(imu_random_);
  r.imu.specific_force_B = specific_force_B + accelerometer_turn_on_ + accelerometer_.value +
                           p.accelerometer_noise_m_s2_rthz * root_rate * Normal3(imu_random_);
  if (Due(steps_, dt_s, p.gps_rate_hz)) {
    const double period = 1 / p.gps_rate_hz;
    gps_horizontal_.Step(period, p.gps_horizontal_m.wander, p.gps_horizontal_m.wander_time_s, gps_random_);
    gps_vertical_.Step(period, p.gps_vertical_m.wander, p.gps_vertical_m.wander_time_s, gps_random_);
    gps_velocity_.Step(period, p.gps_velocity_m_s.wander, p.gps_velocity_m_s.wander_time_s, gps_random_);
    const Eigen::Vector3d white = Normal3(gps_random_);
    GpsSample gps{X_NB.p, v_N + gps_velocity_.value + p.gps_velocity_m_s.white * Normal3(gps_random_)};
    gps.p_N.head<2>() += gps_horizontal_.value.head<2>() + p.gps_horizontal_m.white * white.head<2>();
    gps.p_N.z() += gps_vertical_.value.z() + p.gps_vertical_m.white * white.z();
    r.gps = gps;
  }
  if (Due(steps_, dt_s, p.barometer_rate_hz)) {
    barometer_.Step(1 / p.barometer_rate_hz, p.barometer_m.wander, p.barometer_m.wander_time_s,
                    barometer_random_);
    r.height_m = -X_NB.p.z() + barometer_.value.x() + p.barometer_m.white * barometer_random_.Normal();
  }
  if (Due(steps_, dt_s, p.magnetometer_rate_hz)) {
    r.field_B = X_NB.R.conjugate() * EarthField_N() + magnetometer_turn_on_ +
                p.magnetometer_white_t * Normal3(magnetometer_random_);
  }
  return r;
}

}  // namespace kestrel::sim
