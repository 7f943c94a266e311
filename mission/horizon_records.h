// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mission/horizon_observer.h"
#include "mission/mission_type.h"

// What missions whose report is a HorizonReport declare.
namespace kestrel::mission {

std::vector<TelemetryColumn> HorizonColumns();

// Of the attitude that images gave, and of that by the reference method.
std::vector<Metric> HorizonMetrics();
void AddHorizonMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::mission
