// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "config/yaml_fields.h"
#include "sim/simulator.h"

namespace kestrel {

// What each number of a camera allows and their sum does not: an exposure and a readout that neither the
// period nor the latency has room for, bounds that cross. where: the place of the keys "image" and "mount".
// rows: of the image.
void CheckImage(const ImageParameters& image, int rows, const std::string& where, Mistakes& mistakes);
void CheckMount(const CameraMount& mount, const std::string& where, Mistakes& mistakes);

}  // namespace kestrel
