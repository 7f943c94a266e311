// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"

namespace kestrel::scenarios {

// How true a panorama is. Its images' attitudes are held against the true ones of the camera, after the one rotation
// that brings all of them nearest: which way the panorama lies is not counted.
//
// panorama_rms_deg: of the angles between where it has the middle and the corners of each image and where they truly
// are. panorama_closure_deg: by how much the first image and the one that is a whole turn later lie otherwise to
// each other than they truly do.
std::vector<mission::Metric> PanoramaMetrics();
void AddPanoramaMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
