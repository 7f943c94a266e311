// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/diagnostics.h"
#include "sim/simulator.h"

namespace kestrel::flight {

// What each number of a camera allows and their sum does not: an exposure and a readout that neither the
// period nor the latency has room for, bounds that cross. where: the place of the keys "image" and "mount".
// camera: null where it is not known; then what depends on it is not looked at. With it, a rim, reflection or
// vignetting that leaves light to less than a thousandth of the pixels is refused.
void CheckImage(const sim::ImageParameters& image, const vision::CameraModel* camera, const Place& where,
                Mistakes& mistakes);
void CheckMount(const vision::CameraMount& mount, const Place& where, Mistakes& mistakes);

}  // namespace kestrel::flight
