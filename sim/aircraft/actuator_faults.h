// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/fields.h"
#include "sim/aircraft/rotor_layout.h"

namespace kestrel::sim {

// A fault of a motor or servo while t is in [from_s, until_s), in the vocabulary of PX4's failure injection.
// instance: which, from 1; 0: all of them.
//
//   motors   of a multirotor: in the order of its rotors, of a plus 1 front, 2 right, 3 back, 4 left; of a helicopter: 1, which drives both rotors
//   servos   of a helicopter: 1 collective, 2 longitudinal cyclic, 3 lateral cyclic, 4 the tail's pitch
//            (swashplate with mechanical mixing: a servo for each)
//
//   off      a motor of a multirotor runs down as if asked to stand; a helicopter's gives no power, and its
//            rotors run down freely; a servo is limp, and its blades go to no pitch (assumed)
//   stuck    a motor of a multirotor keeps its speed, a helicopter's its power, a servo its pitch
//   wrong    a rotor of a multirotor gives loss less thrust than asked, a helicopter's motor loss less power;
//            a servo goes to offset_deg more than asked
//   slow     its lag is slowness times what it is
//   ok       none: where this comes first in the list, no other fault of it holds
//
// Of several faults of one at a time the first in the list holds.
struct ActuatorFault {
  std::string component, type;
  int instance = 0;
  double from_s = 0, until_s = 1e9;
  double loss = 0.3;      // wrong, of a motor: share of thrust or power
  double offset_deg = 2;  // wrong, of a servo
  double slowness = 10;   // slow
};

inline void Fields(FieldVisitor& v, ActuatorFault& f) {
  v(Required("component", "what fails: a motor, or a servo of a helicopter"), f.component,
    {"motor", "servo"});
  v(Required("type", "how it fails, in the vocabulary of PX4's failure injection"), f.type,
    {"off", "stuck", "wrong", "slow", "ok"});
  v({"instance", "which of them, from 1; 0: all"}, f.instance, 0, static_cast<int>(kMaxRotors));
  v({"from_s", "when the fault begins, in the time of the flight"}, f.from_s, 0.0, 1e9);
  v({"until_s", "when the fault ends"}, f.until_s, 0.0, 1e9);
  if (f.type == "wrong" && f.component == "motor")
    v({"loss", "share of thrust or power that is lost"}, f.loss, 0.0, 1.0);
  if (f.type == "wrong" && f.component == "servo")
    v({"offset_deg", "what is added to the angle that is asked of the servo"}, f.offset_deg, -30.0, 30.0);
  if (f.type == "slow") v({"slowness", "factor on the time constant"}, f.slowness, 1.0, 1000.0);
}

struct ActuatorParameters {
  std::vector<ActuatorFault> faults;
};

inline void Fields(FieldVisitor& v, ActuatorParameters& p) {
  v({"faults", "faults of motors and servos; of several of one at a time the first in the list holds"},
    p.faults);
}

// The one that holds of an actuator, instance from 1; none, or ok: nullptr.
const ActuatorFault* FaultAt(const std::vector<ActuatorFault>& faults, std::string_view component,
                             int instance, double t_s);

// How a motor or servo is.
struct ActuatorCondition {
  bool off = false, stuck = false;
  double loss = 0, offset = 0, slowness = 1;  // offset: rad
};

struct ActuatorConditions {
  std::array<ActuatorCondition, kMaxRotors> motors;
  std::array<ActuatorCondition, 4> servos;  // those that the aircraft has
};

ActuatorConditions ConditionsAt(const std::vector<ActuatorFault>& faults, double t_s);

}  // namespace kestrel::sim
