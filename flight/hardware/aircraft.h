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
  bool pilot_untold = false;
  vision::LiveCameraOptions camera, ground_camera;
  control::MavlinkOptions mavlink;
  control::AfcsLinkOptions afcs;
  control::AscTecOptions asctec;
};

inline void Fields(FieldVisitor& v, Aircraft& a) {
  v({"safety", "limits of what is sent to the autopilot, and of what may fail for how long"}, a.safety);
  v({"pilot_untold",
     "fly although the autopilot does not tell of the pilot's switch: the pilot takes over elsewhere"},
    a.pilot_untold);
  v({"camera", "live camera: when to open it anew, and the delay of its time stamps"}, a.camera);
  v({"ground_camera", "the same of the camera on the ground"}, a.ground_camera);
  v({"mavlink", "link to a MAVLink 2 autopilot (PX4, ArduPilot)"}, a.mavlink);
  v({"afcs", "link to a Rotomotion AFCS"}, a.afcs);
  v({"asctec", "link to an AscTec low-level processor"}, a.asctec);
}

// file: empty for an aircraft as it is by default. overrides: "key.path=value". All mistakes are gathered.
Aircraft LoadAircraft(const std::string& file, const std::vector<std::string>& overrides, Mistakes& mistakes);

// The link to an autopilot by its address: "mavlink:udp://HOST:PORT", "mavlink:udpin://HOST:PORT",
// "mavlink:tcp://HOST:PORT", "afcs:udp://HOST:PORT", "asctec:serial:DEVICE". Null: the address is a mistake.
std::unique_ptr<control::AutopilotLink> MakeLink(const std::string& address, const Aircraft& aircraft,
                                                 Mistakes& mistakes);

}  // namespace kestrel::flight
