// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "control/autopilot.h"

namespace kestrel::mission {

// A commanded velocity ahead and down and the yaw rate as arrows along the lower edge of a video's frame; one
// of full length is as much as full has there.
void DrawCommand(cv::Mat& bgr, const control::VelocitySetpoint& command,
                 const control::VelocitySetpoint& full);

}  // namespace kestrel::mission
