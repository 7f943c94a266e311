// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "vision/enhance/stabilisation/gyro_track.h"

namespace kestrel::vision {

// The angular rates in a CSV whose header names the columns t_s and, in the camera's axes (x right, y down, z forward),
// wx_rad_s, wy_rad_s, wz_rad_s, or the same in _deg_s; others are passed over. What is no such file, or has no number
// where one is due, or times that do not go up, is a mistake, with its line.
std::vector<GyroSample> ReadGyroFile(const std::string& file, Mistakes& mistakes);

}  // namespace kestrel::vision
