// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/aircraft/multirotor.h"

namespace kestrel::sim {

// What a multirotor looks like and stands on where nobody has drawn it: an MJCF fragment with the body "vehicle", arms,
// motors and rotors where its rotors are, the front ones orange, and two skids of the Pelican's proportions.
std::string MultirotorShape(const MultirotorParameters& p);

}  // namespace kestrel::sim
