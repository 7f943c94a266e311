// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/timings/timed_work.h"

namespace kestrel::bench {

// Multiplications and additions that wait for one another.
Block ArithmeticLoop();
// Reads all over a buffer that is larger than caches are, half of them in no order.
Block MemoryLoop();

}  // namespace kestrel::bench
