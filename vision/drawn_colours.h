// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace kestrel::vision {

// What is drawn for people has one colour everywhere: in videos as in plots and on pages. They are of Okabe and
// Ito's set, which colour-blind people tell apart. As BGR.
inline const cv::Scalar kFixColour(0x00, 0x9F, 0xE6);       // what the camera measured
inline const cv::Scalar kEstimateColour(0xB2, 0x72, 0x00);  // what the autopilot knows
inline const cv::Scalar kSetpointColour(0x73, 0x9E, 0x00);  // what is wanted
inline const cv::Scalar kLimitColour(0x00, 0x5E, 0xD5);     // what must not be, and is
inline const cv::Scalar kPointColour(0xE9, 0xB4, 0x56);     // what was looked at, and does not count

}  // namespace kestrel::vision
