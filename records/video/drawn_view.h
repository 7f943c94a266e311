// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "mission/mission.h"

namespace kestrel::records {

// A frame as a video has it: in colour, with what the mission saw in it, and below it a strip with the time of
// the flight, what flies (flight_mode.h) and what the mission says of the frame: no word lies over the image.
// t_s: of the frame's row in telemetry.csv.
cv::Mat DrawnView(const vision::Frame& frame, double t_s, const mission::Mission& mission,
                  const std::string& mode);
// The same of flight code that is elsewhere, and draws nothing.
cv::Mat DrawnView(const vision::Frame& frame, double t_s, const std::string& mode);

}  // namespace kestrel::records
