// SPDX-License-Identifier: Apache-2.0
#include "sim/sensor/sensor_monitor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace kestrel::sim {
namespace {

constexpr double kPatiencePeriods = 5;
constexpr double kInertialPatience_s = 0.1;
constexpr int kStuckReadings = 10;

const char* NameOf(SensorHealth health) {
  switch (health) {
    case SensorHealth::kSilent:
      return "silent";
    case SensorHealth::kStuck:
      return "stuck";
    case SensorHealth::kRefused:
      return "refused";
    default:
      return "ok";
  }
}

}  // namespace

std::string NameOf(const NavigationHealth& h) {
  const bool by_gps = h.gps == SensorHealth::kOk;
  std::vector<std::string> words;
  const auto add = [&](const char* sensor, SensorHealth health, const char* without) {
    if (health != SensorHealth::kOk)
      words.push_back(fmt::format("{} {}: {}", sensor, NameOf(health), without));
  };
  add("gyro", h.gyro, "rates as last received");
  add("accel", h.accelerometer, "forces as last received");
  add("mag", h.compass, "heading by gyro");
  add("baro", h.barometer, by_gps ? "height by gps" : "height by accel");
  add("gps", h.gps, "dead reckoning");
  return words.empty() ? "ok" : fmt::format("{}", fmt::join(words, ", "));
}

template <int size>
SensorHealth SensorMonitor::Record<size>::Step(double dt_s, bool spoke,
                                               const Eigen::Matrix<double, size, 1>& measured,
                                               double patience_s, bool inertial) {
  silent_s = spoke ? 0 : silent_s + dt_s;
  same_s += dt_s;
  if (spoke) {
    if (measured != last) same = 0, same_s = 0;
    ++same;
    last = measured;
  }
  if (silent_s > patience_s) return SensorHealth::kSilent;
  const bool stuck = inertial ? same > 1 && same_s > patience_s : same >= kStuckReadings;
  return stuck ? SensorHealth::kStuck : SensorHealth::kOk;
}

SensorMonitor::SensorMonitor(const SensorParameters& sensors)
    : gps_period_s_(1 / sensors.gps_rate_hz),
      barometer_period_s_(1 / sensors.barometer_rate_hz),
      magnetometer_period_s_(1 / sensors.magnetometer_rate_hz) {}

void SensorMonitor::Step(double dt_s, const SensorReadings& r) {
  health_.gyro = gyro_.Step(dt_s, r.gyro_spoke, r.imu.w_B, kInertialPatience_s, true);
  health_.accelerometer =
      accelerometer_.Step(dt_s, r.accelerometer_spoke, r.imu.specific_force_B, kInertialPatience_s, true);
  health_.compass = compass_.Step(dt_s, r.field_B.has_value(), r.field_B.value_or(Eigen::Vector3d::Zero()),
                                  kPatiencePeriods * magnetometer_period_s_, false);
  health_.barometer =
      barometer_.Step(dt_s, r.height_m.has_value(), Eigen::Matrix<double, 1, 1>(r.height_m.value_or(0)),
                      kPatiencePeriods * barometer_period_s_, false);
  Eigen::Matrix<double, 6, 1> fix = Eigen::Matrix<double, 6, 1>::Zero();
  if (r.gps) fix << r.gps->p_N, r.gps->v_N;
  health_.gps = gps_.Step(dt_s, r.gps.has_value(), fix, kPatiencePeriods * gps_period_s_, false);
}

}  // namespace kestrel::sim
