// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A fault of the attitude that an autopilot has from its own sensors, while t is in [from_s, until_s). The
// rate gyros that damp the aircraft go on in each.
//
//   drift   the attitude turns by drift_deg_s more than the aircraft, and no correction holds it
//   freeze  the attitude stays what it was
//   silent  there is none
struct AttitudeFault {
  std::string type;
  double from_s = 0, until_s = 1e9;
  Eigen::Vector3d drift_deg_s{3, -2, 2};  // in B
};

inline void Fields(FieldVisitor& v, AttitudeFault& f) {
  v(Required("type", "what becomes of the attitude: it drifts, stays what it was, or is missing"), f.type,
    {"drift", "freeze", "silent"});
  v({"from_s", "when the fault begins, in the time of the flight"}, f.from_s, 0.0, 1e9);
  v({"until_s", "when the fault ends"}, f.until_s, 0.0, 1e9);
  if (f.type == "drift")
    v({"drift_deg_s", "rate at which the estimate turns away from the aircraft, in B"}, f.drift_deg_s, -90.0,
      90.0);
}

// The first of the faults that is on; none: nullptr.
inline const AttitudeFault* FaultAt(const std::vector<AttitudeFault>& faults, double t_s) {
  for (const AttitudeFault& fault : faults)
    if (t_s >= fault.from_s && t_s < fault.until_s) return &fault;
  return nullptr;
}

}  // namespace kestrel::sim
