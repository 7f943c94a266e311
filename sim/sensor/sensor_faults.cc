// SPDX-License-Identifier: Apache-2.0
#include "sim/sensor/sensor_faults.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/gravity.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kRounding_s = 1e-9;
constexpr SensorRanges kRanges;

Eigen::Vector3d Uniform3(double range, RandomStream& random) {
  const double x = random.Uniform(-range, range), y = random.Uniform(-range, range);
  return {x, y, random.Uniform(-range, range)};
}

// Garbage of a sensor, and a reading that is wrong. The argument of type T tells the kinds of readings apart.
Eigen::Vector3d Garbage(const SensorFault& fault, RandomStream& random, const Eigen::Vector3d&) {
  if (fault.component == "gyro") return Uniform3(Radians(kRanges.gyro_deg_s), random);
  if (fault.component == "accel") return Uniform3(kRanges.accelerometer_m_s2, random);
  return Uniform3(kRanges.magnetometer_t, random);
}
double Garbage(const SensorFault&, RandomStream& random, double) {
  return random.Uniform(kRanges.height_low_m, kRanges.height_high_m);
}
GpsSample Garbage(const SensorFault&, RandomStream& random, const GpsSample&) {
  const Eigen::Vector3d p_N = Uniform3(kRanges.gps_m, random);
  return {p_N, Uniform3(kRanges.gps_m_s, random)};
}

Eigen::Vector3d Wrong(const SensorFault& fault, const Eigen::Vector3d& measured) {
  if (fault.component == "gyro") return measured + fault.gyro_offset_deg_s.unaryExpr(&Radians);
  if (fault.component == "accel") return measured + fault.accelerometer_offset_m_s2;
  return measured + 1e-6 * fault.magnetometer_offset_ut;
}
double Wrong(const SensorFault& fault, double measured) { return measured + fault.barometer_offset_m; }
GpsSample Wrong(const SensorFault& fault, const GpsSample& measured) {
  return {measured.p_N + fault.gps_offset_m, measured.v_N + fault.gps_offset_m_s};
}

bool Speaks(const SensorFault& intermittent, double t_s) {
  const double periods = (t_s - intermittent.from_s + kRounding_s) / intermittent.period_s;
  return periods - std::floor(periods) < intermittent.duty;
}

}  // namespace

template <class T>
SensorFaults::Channel<T>::Channel(const char* of, std::uint64_t seed)
    : component(of), random(seed, component + " garbage") {}

template <class T>
std::optional<T> SensorFaults::Channel<T>::Pass(const std::vector<SensorFault>& faults, double t_s,
                                                const std::optional<T>& measured) {
  const SensorFault* now = FaultAt(faults, component, t_s);
  if (now != fault) {
    fault = now;
    next_s = -std::numeric_limits<double>::infinity();
    late.clear();
  }
  std::optional<T> heard = measured;
  if (fault) {
    const std::string& type = fault->type;
    if (type == "off") heard.reset();
    if (type == "stuck" && measured && last) heard = last;
    if (type == "garbage" && measured) heard = Garbage(*fault, random, *measured);
    if (type == "wrong" && measured) heard = Wrong(*fault, *measured);
    if (type == "intermittent" && !Speaks(*fault, t_s)) heard.reset();
    if (type == "slow" && measured) {
      if (t_s < next_s - kRounding_s)
        heard.reset();
      else
        next_s = t_s + 1 / fault->rate_hz;
    }
    if (type == "delayed") {
      if (measured) late.emplace_back(t_s + fault->delay_s, *measured);
      heard.reset();
      if (!late.empty() && late.front().first <= t_s + kRounding_s) {
        heard = late.front().second;
        late.pop_front();
      }
    }
  }
  if (heard) last = heard;
  return heard;
}

SensorFaults::SensorFaults(std::vector<SensorFault> faults, std::uint64_t seed)
    : faults_(std::move(faults)),
      gyro_("gyro", seed),
      accelerometer_("accel", seed),
      magnetometer_("mag", seed),
      barometer_("baro", seed),
      gps_("gps", seed) {}

void SensorFaults::Change(std::vector<SensorFault> faults) {
  const auto go_on = [&](auto& channel) {
    if (faults.empty()) channel.last.reset(), channel.late.clear();
    if (!channel.fault) return;
    const auto same = std::find(faults.begin(), faults.end(), *channel.fault);
    channel.fault = same != faults.end() ? &*same : nullptr;
  };
  go_on(gyro_), go_on(accelerometer_), go_on(magnetometer_), go_on(barometer_), go_on(gps_);
  faults_ = std::move(faults);  // whose elements stay where they are
}

void SensorFaults::Apply(double t_s, SensorReadings& readings) {
  if (faults_.empty()) return;
  // Of the inertial sensors a step always has a value: of one that says nothing its last.
  const auto inertial = [&](auto& channel, const Eigen::Vector3d& at_rest, Eigen::Vector3d& value,
                            bool& spoke) {
    spoke = channel.Pass(faults_, t_s, std::optional(value)).has_value();
    value = channel.last.value_or(at_rest);
  };
  inertial(gyro_, Eigen::Vector3d::Zero(), readings.imu.w_B, readings.gyro_spoke);
  inertial(accelerometer_, {0, 0, -kGravity_m_s2}, readings.imu.specific_force_B,
           readings.accelerometer_spoke);
  readings.field_B = magnetometer_.Pass(faults_, t_s, readings.field_B);
  readings.height_m = barometer_.Pass(faults_, t_s, readings.height_m);
  readings.gps = gps_.Pass(faults_, t_s, readings.gps);
}

}  // namespace kestrel::sim
