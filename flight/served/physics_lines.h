// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kestrel::flight {

// How to fly by the physics that are served, line by line: the command of the autopilot's own program, in its own
// folder, and that of `kestrel fly`. kind: "ardupilot" or "px4". where: "udp://HOST:PORT", as it can be reached.
// vehicle: a name in models/vehicles or a file; a file of parameters is named where it is there. fly: the command up to
// its --autopilot; empty: no camera is served, so that nothing of Kestrel can fly.
std::string PhysicsLines(const std::string& kind, const std::string& where, const std::string& vehicle,
                         const std::string& fly);

}  // namespace kestrel::flight
