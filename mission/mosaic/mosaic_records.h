// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/mission_type.h"

// What missions whose report is a MosaicReport declare, beside the path that they fly (mission/path/path_records.h).
namespace kestrel::mission {

std::vector<TelemetryColumn> MosaicColumns();

std::vector<Metric> MosaicMetrics();
void AddMosaicMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::mission
