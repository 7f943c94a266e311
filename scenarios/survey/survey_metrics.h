// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"

namespace kestrel::scenarios {

// How true a mosaic of the ground is, by 200 places on it. Where the mosaic shows a place is said by the image that
// has it nearest to its middle. The ground is the plane z = 0 of N; what stands on it is seen elsewhere, and not
// judged.
//
// mosaic_rms_px: of the distances of those places from where the homography from the ground that fits them best has
// them, in pixels of the mosaic: neither its scale nor where its first image lay is counted as an error.
// mosaic_closure_px: how far apart the first and the last image that show a place have it, where they are of
// different passes.
std::vector<mission::Metric> SurveyMetrics();
void AddSurveyMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
