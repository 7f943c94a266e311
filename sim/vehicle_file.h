// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "base/yaml/fields.h"
#include "sim/aircraft/airframe.h"
#include "sim/aircraft/multirotor_shape.h"
#include "sim/autopilot/emulated_autopilot.h"
#include "sim/camera/pan_tilt.h"

namespace kestrel::sim {

// models/vehicles/NAME/NAME.yaml: the airframe, how its autopilot is tuned, and what turns its camera, if
// anything does.
struct VehicleFile {
  std::string kind = "multirotor";
  AirframeParameters airframe;
  AutopilotParameters autopilot;
  std::optional<PanTiltParameters> platform;
};

inline void Fields(FieldVisitor& v, VehicleFile& f) {
  v({"kind", "what the airframe is; it decides the other keys"}, f.kind, {"multirotor", "helicopter"});
  if (f.kind == "helicopter" && !std::holds_alternative<HelicopterParameters>(f.airframe))
    f.airframe = HelicopterParameters{};
  std::visit([&](auto& airframe) { Fields(v, airframe); }, f.airframe);
  v({"autopilot", "loops and limits of its low-level autopilot"}, f.autopilot);
  v({"platform", "pan-tilt platform of the camera; null: the camera is fixed"}, f.platform);
}

}  // namespace kestrel::sim
