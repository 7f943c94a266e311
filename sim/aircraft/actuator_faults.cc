// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/actuator_faults.h"

#include "geometry/tait_bryan.h"
#include "sim/sensor/sensor_fault.h"

namespace kestrel::sim {

const ActuatorFault* FaultAt(const std::vector<ActuatorFault>& faults, std::string_view component,
                             int instance, double t_s) {
  for (const ActuatorFault& fault : faults) {
    if (fault.component == component && (fault.instance == 0 || fault.instance == instance) &&
        IsOn(fault, t_s)) {
      return fault.type == "ok" ? nullptr : &fault;
    }
  }
  return nullptr;
}

ActuatorConditions ConditionsAt(const std::vector<ActuatorFault>& faults, double t_s) {
  ActuatorConditions all;
  const auto settle = [&](const char* component, auto& conditions) {
    for (std::size_t i = 0; i < conditions.size(); ++i) {
      const ActuatorFault* fault = FaultAt(faults, component, static_cast<int>(i) + 1, t_s);
      if (!fault) continue;
      ActuatorCondition& c = conditions[i];
      c.off = fault->type == "off";
      c.stuck = fault->type == "stuck";
      if (fault->type == "wrong") c.loss = fault->loss, c.offset = Radians(fault->offset_deg);
      if (fault->type == "slow") c.slowness = fault->slowness;
    }
  };
  settle("motor", all.motors);
  settle("servo", all.servos);
  return all;
}

}  // namespace kestrel::sim
