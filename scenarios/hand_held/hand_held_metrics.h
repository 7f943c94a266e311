// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::scenarios {

std::vector<mission::TelemetryColumn> HandHeldColumns();

// The errors of thesis 3.4 by the motion capture, the truth: of the landmark in the axes of the image, where
// depth is told from what lies across; of the camera in the room, into which the estimated rotation enters
// with the distance for its lever; and of the chain of homographies alone.
std::vector<mission::Metric> HandHeldMetrics();
void AddHandHeldMetrics(const std::vector<records::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
