// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "mission/mission.h"

namespace kestrel::records {

// A frame as a video has it: in colour, with what the mission saw in it, and in a strip of kModeStrip_px
// under it what flies (flight_mode.h), where no mission draws.
inline constexpr int kModeStrip_px = 22;
cv::Mat DrawnView(const vision::Frame& frame, const mission::Mission& mission, const std::string& mode);
// The same of flight code that is elsewhere, and draws nothing.
cv::Mat DrawnView(const vision::Frame& frame, const std::string& mode);

}  // namespace kestrel::records
