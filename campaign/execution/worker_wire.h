// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "campaign/execution/run_result.h"
#include "campaign/execution/worker_pool.h"

namespace kestrel::campaign {

// What goes between the pool and a worker, a line of JSON each: orders there; back one greeting, when it can
// fly, and then a report for each order. Numbers come through to their last bit.
std::string OrderLine(const RunOrder& order);

// A run and what it cost the worker: its execution has wall_s of the flight alone and peak_mib.
std::string ReportLine(const RunResult& result);

constexpr const char* kGreetingLine = "{\"ready\":true}\n";

// From a line without its end. Throw std::runtime_error with what is wrong.
RunOrder OrderOf(const std::string& line);
RunResult ReportOf(const std::string& line);
bool IsGreeting(const std::string& line);

}  // namespace kestrel::campaign
