// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// What each servo law does on each of the canonical tasks (bench/servo/servo_tasks.h), printed as a table of
// its own; the figures of it: for each task, how many laws converge, and for each law, on how many tasks.
void BenchServo(std::vector<records::Figure>& table);

}  // namespace kestrel::bench
