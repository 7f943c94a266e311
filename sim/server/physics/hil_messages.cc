// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/hil_messages.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

// fields_updated
constexpr std::uint32_t kAccelerometer = 1 | 2 | 4, kGyro = 8 | 16 | 32, kMagnetometer = 64 | 128 | 256;
constexpr std::uint32_t kBarometer = 512 | 2048 | 4096;  // pressure, its altitude, temperature

constexpr double kGaussPerTesla = 1e4;
constexpr double kLapse_k_m = 0.0065, kSeaLevel_k = 288.15, kSeaLevel_hpa = 1013.25;
constexpr double kExponent = kGravity_m_s2 / (287.05287 * kLapse_k_m);

// To the nearest that there is.
template <class Integer>
Integer Rounded(double value) {
  return static_cast<Integer>(std::clamp(std::round(value),
                                         static_cast<double>(std::numeric_limits<Integer>::min()),
                                         static_cast<double>(std::numeric_limits<Integer>::max())));
}

}  // namespace

double StandardPressure_hpa(double altitude_m) {
  return kSeaLevel_hpa * std::pow(1 - kLapse_k_m * altitude_m / kSeaLevel_k, kExponent);
}

double StandardTemperature_c(double altitude_m) { return kSeaLevel_k - 273.15 - kLapse_k_m * altitude_m; }

control::wire::mavlink::HilSensor ToHilSensor(std::uint64_t time_usec, const GatheredReadings& readings,
                                              SlowSensors& slow, const GeodeticOrigin& origin) {
  control::wire::mavlink::HilSensor m;
  m.time_usec = time_usec;
  m.fields_updated = kAccelerometer | kGyro;
  if (readings.field_B) {
    slow.field_B = *readings.field_B;
    m.fields_updated |= kMagnetometer;
  }
  if (readings.height_m) {
    slow.height_m = *readings.height_m;
    m.fields_updated |= kBarometer;
  }
  const ImuSample imu = readings.MeanImu();
  const Eigen::Vector3f force_B = imu.specific_force_B.cast<float>();
  const Eigen::Vector3f w_B = imu.w_B.cast<float>();
  const Eigen::Vector3f field_B = (slow.field_B * kGaussPerTesla).cast<float>();
  m.xacc = force_B.x(), m.yacc = force_B.y(), m.zacc = force_B.z();
  m.xgyro = w_B.x(), m.ygyro = w_B.y(), m.zgyro = w_B.z();
  m.xmag = field_B.x(), m.ymag = field_B.y(), m.zmag = field_B.z();
  const double altitude_m = origin.altitude_m + slow.height_m;
  m.abs_pressure = static_cast<float>(StandardPressure_hpa(altitude_m));
  m.pressure_alt = static_cast<float>(altitude_m);
  m.temperature = static_cast<float>(StandardTemperature_c(altitude_m));
  return m;
}

control::wire::mavlink::HilGps ToHilGps(std::uint64_t time_usec, const GpsSample& gps,
                                        const GeodeticOrigin& origin) {
  control::wire::mavlink::HilGps m;
  m.time_usec = time_usec;
  const GeodeticPosition position = GeodeticOf(origin, gps.p_N);
  m.lat = Rounded<std::int32_t>(position.latitude_deg * 1e7);
  m.lon = Rounded<std::int32_t>(position.longitude_deg * 1e7);
  m.alt = Rounded<std::int32_t>(position.altitude_m * 1e3);
  m.eph = m.epv = 100;
  m.vel = Rounded<std::uint16_t>(gps.v_N.head<2>().norm() * 100);
  m.vn = Rounded<std::int16_t>(gps.v_N.x() * 100);
  m.ve = Rounded<std::int16_t>(gps.v_N.y() * 100);
  m.vd = Rounded<std::int16_t>(gps.v_N.z() * 100);
  double course_deg = std::atan2(gps.v_N.y(), gps.v_N.x()) * 180 / std::numbers::pi;
  if (course_deg < 0) course_deg += 360;
  m.cog = static_cast<std::uint16_t>(Rounded<std::uint16_t>(course_deg * 100) % 36000);
  m.fix_type = 3;
  m.satellites_visible = 10;
  return m;
}

control::wire::mavlink::HilStateQuaternion ToHilState(std::uint64_t time_usec, const Truth& truth,
                                                      const Eigen::Vector3d& specific_force_B,
                                                      const GeodeticOrigin& origin) {
  control::wire::mavlink::HilStateQuaternion m;
  m.time_usec = time_usec;
  const Eigen::Quaternionf q = truth.X_NB.R.cast<float>();
  m.attitude_quaternion = {q.w(), q.x(), q.y(), q.z()};
  const Eigen::Vector3f w_B = truth.w_B.cast<float>();
  m.rollspeed = w_B.x(), m.pitchspeed = w_B.y(), m.yawspeed = w_B.z();
  const GeodeticPosition position = GeodeticOf(origin, truth.X_NB.p);
  m.lat = Rounded<std::int32_t>(position.latitude_deg * 1e7);
  m.lon = Rounded<std::int32_t>(position.longitude_deg * 1e7);
  m.alt = Rounded<std::int32_t>(position.altitude_m * 1e3);
  m.vx = Rounded<std::int16_t>(truth.v_N.x() * 100);
  m.vy = Rounded<std::int16_t>(truth.v_N.y() * 100);
  m.vz = Rounded<std::int16_t>(truth.v_N.z() * 100);
  const double airspeed_cm_s = (truth.v_N - truth.wind_N).norm() * 100;
  m.ind_airspeed = m.true_airspeed = Rounded<std::uint16_t>(airspeed_cm_s);
  const Eigen::Vector3d force_mg = specific_force_B / (kGravity_m_s2 * 1e-3);
  m.xacc = Rounded<std::int16_t>(force_mg.x());
  m.yacc = Rounded<std::int16_t>(force_mg.y());
  m.zacc = Rounded<std::int16_t>(force_mg.z());
  return m;
}

}  // namespace kestrel::sim
