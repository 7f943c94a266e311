// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

namespace kestrel {

// The stamp of a time in s that is kept in double. Exact for times that are whole steps of a simulated world,
// whose product with the step is off by much less than half a nanosecond.
inline std::int64_t Nanoseconds(double t_s) { return std::llround(t_s * 1e9); }

}  // namespace kestrel
