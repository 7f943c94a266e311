// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "campaign/execution/run_result.h"
#include "campaign/table/sample_table.h"

namespace kestrel::campaign {

// The results as CSV (RFC 4180), a line per run in the order of the rows: row, each key that varies, status,
// outcome, each metric that any run has by name, state_hash, image_hash. Numbers read back to the same bits;
// a metric that a run does not have is empty, one that is not finite is nan, inf or -inf.
std::string ToCsv(const SampleTable& table, const std::vector<RunResult>& results);

}  // namespace kestrel::campaign
