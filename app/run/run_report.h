// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "records/telemetry/flight_log.h"

namespace kestrel::app {

// What a run came to, in a line: "landing, seed 1: FAILED: 2 of 4 criteria not met (landed)".
std::string Verdict(const records::Summary& summary, bool colours);

// A line for each criterion.
std::string CriteriaLines(const records::Summary& summary, bool colours);

// A line for each criterion that is not met.
std::string MissedCriteria(const records::Summary& summary, bool colours);

// The end of a run: verdict, all criteria, how long it took, and where it can be looked at.
std::string RunReport(const records::Summary& summary, const std::string& report, bool colours);

}  // namespace kestrel::app
