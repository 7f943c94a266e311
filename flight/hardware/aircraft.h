// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "control/link/afcs_link.h"
#include "control/link/asctec_link.h"
#include "control/link/mavlink_link.h"
#include "control/safety/safety.h"
#include "vision/capture/live_camera.h"

namespace kestrel::flight {

// What a flight must know of a real aircraft: a YAML file of its owner's.
struct Aircraft {
  control::SafetyLimits safety;
  // An autopilot that does not tell of the pilot's switch is flown all the same: he takes over elsewhere.
  bool pilot_untold = false;
  vision::LiveCameraOptions camera;
  control::MavlinkOptions mavlink;
  control::AfcsLinkOptions afcs;
  control::AscTecOptions asctec;
};

inline void Fields(FieldVisitor& v, Aircraft& a) {
  v("safety", a.safety);
  v("pilot_untold", a.pilot_untold);
  v("camera", a.camera);
  v("mavlink", a.mavlink);
  v("afcs", a.afcs);
  v("asctec", a.asctec);
}

// file: empty for an aircraft as it is by default. overrides: "key.path=value". All mistakes are gathered.
Aircraft LoadAircraft(const std::string& file, const std::vector<std::string>& overrides, Mistakes& mistakes);

// The link to an autopilot by its address: "mavlink:udp://HOST:PORT", "mavlink:udpin://HOST:PORT",
// "afcs:udp://HOST:PORT", "asctec:serial:DEVICE". Null: the address is a mistake.
std::unique_ptr<control::AutopilotLink> MakeLink(const std::string& address, const Aircraft& aircraft,
                                                 Mistakes& mistakes);

}  // namespace kestrel::flight
