// SPDX-License-Identifier: Apache-2.0
#include "sim/fault_schedule.h"

#include <fmt/format.h>

#include <algorithm>

namespace kestrel::sim {
namespace {

struct ActuatorCounts {
  int motors, servos;
};
ActuatorCounts CountsOf(const AirframeParameters& aircraft) {
  const auto* multirotor = std::get_if<MultirotorParameters>(&aircraft);
  return multirotor ? ActuatorCounts{static_cast<int>(LayoutOf(*multirotor).count), 0} : ActuatorCounts{1, 4};
}

template <class Fault>
void CheckTimes(const std::vector<Fault>& faults, const std::string& key, const Place& where,
                Mistakes& mistakes) {
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (faults[i].until_s > faults[i].from_s) continue;
    mistakes.Add(where, fmt::format("{}.{}.until_s", key, i),
                 fmt::format("{} is not after from_s = {}", faults[i].until_s, faults[i].from_s));
  }
}

}  // namespace

std::vector<StateChange> ChangesOf(const std::vector<SensorFault>& sensors,
                                   const std::vector<ActuatorFault>& actuators,
                                   const AirframeParameters& aircraft) {
  std::vector<double> times;
  for (const SensorFault& f : sensors) times.insert(times.end(), {f.from_s, f.until_s});
  for (const ActuatorFault& f : actuators) times.insert(times.end(), {f.from_s, f.until_s});
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());

  std::vector<StateChange> changes;
  const auto add = [&](const std::string& what, auto fault_at) {
    std::string was = "ok";
    for (const double t : times) {
      const auto* fault = fault_at(t);
      const std::string is = fault ? fault->type : "ok";
      if (is != was) changes.push_back({t, what, is});
      was = is;
    }
  };
  for (const char* sensor : {"gyro", "accel", "mag", "baro", "gps"})
    add(sensor, [&](double t) { return FaultAt(sensors, sensor, t); });
  const ActuatorCounts counts = CountsOf(aircraft);
  for (int i = 1; i <= counts.motors; ++i)
    add(fmt::format("motor {}", i), [&](double t) { return FaultAt(actuators, "motor", i, t); });
  for (int i = 1; i <= counts.servos; ++i)
    add(fmt::format("servo {}", i), [&](double t) { return FaultAt(actuators, "servo", i, t); });
  std::stable_sort(changes.begin(), changes.end(),
                   [](const StateChange& a, const StateChange& b) { return a.t_s < b.t_s; });
  return changes;
}

void CheckFaults(const SensorParameters& sensors, const ActuatorParameters& actuators,
                 const AirframeParameters& aircraft, const Place& where_sensors, const Place& where_actuators,
                 Mistakes& mistakes) {
  CheckTimes(sensors.faults, "sensors.faults", where_sensors, mistakes);
  for (std::size_t i = 0; i < sensors.faults.size(); ++i) {
    const SensorFault& fault = sensors.faults[i];
    if (fault.type != "slow") continue;
    const double rate_hz = fault.component == "gps"    ? sensors.gps_rate_hz
                           : fault.component == "baro" ? sensors.barometer_rate_hz
                           : fault.component == "mag"  ? sensors.magnetometer_rate_hz
                                                       : 500;
    if (fault.rate_hz < rate_hz) continue;
    mistakes.Add(where_sensors, fmt::format("sensors.faults.{}.rate_hz", i),
                 fmt::format("{} is not slow for this {}", fault.rate_hz, fault.component),
                 fmt::format("valid: less than its {} Hz", rate_hz));
  }
  CheckTimes(actuators.faults, "actuators.faults", where_actuators, mistakes);
  const ActuatorCounts counts = CountsOf(aircraft);
  for (std::size_t i = 0; i < actuators.faults.size(); ++i) {
    const ActuatorFault& fault = actuators.faults[i];
    const int count = fault.component == "motor" ? counts.motors : counts.servos;
    const std::string key = fmt::format("actuators.faults.{}", i);
    if (count == 0)
      mistakes.Add(where_actuators, key + ".component", "a multirotor has no servo", "valid: motor");
    else if (fault.instance > count)
      mistakes.Add(where_actuators, key + ".instance",
                   fmt::format("there is no {} {}", fault.component, fault.instance),
                   fmt::format("valid: 0 (all) to {}", count));
  }
}

}  // namespace kestrel::sim
