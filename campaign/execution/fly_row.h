// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "campaign/execution/run_result.h"
#include "campaign/execution/worker_pool.h"

namespace kestrel::campaign {

// Flies an order here, in this process: what a worker does, and a replay. Never throws for what the row does;
// its execution has wall_s of the flight alone, the recording and peak_mib.
RunResult FlyRow(const RunOrder& order);

}  // namespace kestrel::campaign
