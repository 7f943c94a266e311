// SPDX-License-Identifier: Apache-2.0
#include "control/link/afcs_settings.h"

#include <cmath>

#include "base/yaml/yaml_fields.h"

namespace kestrel::control::wire {
namespace {

double CommandFor(double wanted, const AfcsAxis& axis) {
  if (wanted == 0) return axis.offset;
  return axis.offset + wanted + std::copysign(axis.dead_zone, wanted);
}
double ObeyedOf(double command, const AfcsAxis& axis) {
  const double felt = command - axis.offset;
  if (std::abs(felt) <= axis.dead_zone) return 0;
  return felt - std::copysign(axis.dead_zone, felt);
}

}  // namespace

AfcsProfile ProfileOf(const AfcsSettings& settings) {
  if (settings.profile == "thesis") return ThesisAfcsProfile();
  Mistakes mistakes;
  AfcsProfile profile;
  Read(LoadConfig(settings.profile, {}, mistakes), profile, mistakes);
  mistakes.ThrowIfAny();
  for (const std::string& mistake : MistakesOf(profile)) mistakes.Add(settings.profile, "", mistake);
  mistakes.ThrowIfAny();
  return profile;
}

AfcsTeleop TeleopFor(const VelocitySetpoint& wanted, const AfcsTeleopAxes& axes) {
  const double down = axes.alt_up ? -1 : 1;
  return {CommandFor(wanted.v_H.x(), axes.fore), CommandFor(wanted.v_H.y(), axes.side),
          CommandFor(down * wanted.v_H.z(), axes.alt), CommandFor(wanted.yaw_rate, axes.hdg)};
}

VelocitySetpoint VelocityOf(const AfcsTeleop& teleop, const AfcsTeleopAxes& axes) {
  const double down = axes.alt_up ? -1 : 1;
  return {{ObeyedOf(teleop.fore, axes.fore), ObeyedOf(teleop.side, axes.side),
           down * ObeyedOf(teleop.alt, axes.alt)},
          ObeyedOf(teleop.hdg, axes.hdg)};
}

}  // namespace kestrel::control::wire
