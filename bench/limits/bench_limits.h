// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "records/figures.h"

namespace kestrel::bench {

// What this machine gives; what a frame needs at least of it and takes; what each stage of a flight takes, and how much
// two cores do of what they could. Prints tables, and adds their figures. Throws InputError.
void BenchLimits(std::vector<records::Figure>& figures);

}  // namespace kestrel::bench
