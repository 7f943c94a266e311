// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "flight/simulated/scenario.h"
#include "geometry/truth.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::flight {

// Judges a flight whose flight code is elsewhere: its metrics, criteria and whether it has passed, by what is of the
// truth alone. Criteria that only the flight code could judge are left out, each said. touch: the instant before the
// first touch-down. Whether anybody flew it is for the caller to judge.
void JudgeByTruth(const Scenario& scenario, const std::vector<records::LogRow>& rows,
                  const std::optional<Truth>& touch, const std::function<void(const std::string&)>& say,
                  records::Summary& summary);

}  // namespace kestrel::flight
