// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace kestrel {

// Wall clock: for what a stage costs, never for what a flight does.
inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace kestrel
