// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "scenarios/mission.h"

namespace kestrel {

// A frame as a video has it: in colour, with what the mission saw in it, and in the lower left corner whether
// this is the simulator or a real aircraft (flight_mode.h).
cv::Mat DrawnView(const Frame& frame, const Mission& mission, const char* mode);

}  // namespace kestrel
