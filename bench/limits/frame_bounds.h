// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "bench/limits/frame_stages.h"
#include "bench/limits/machine_rates.h"

namespace kestrel::bench {

// What drawing a frame takes at least on one core, whoever draws it by a ray to each pixel and eight to those at edges,
// each bound by itself: the three go on side by side, so the frame needs the longest of them.
struct FrameBounds {
  double memory_ms = 0;      // the rays' directions and the texels are read once, the picture is written once
  double random_ms = 0;      // of texels, two beside each other at once
  double arithmetic_ms = 0;  // as if all of it were multiply-adds of whole vectors
  double Least() const { return std::max({memory_ms, random_ms, arithmetic_ms}); }
};

FrameBounds BoundsOf(const FrameContent& content, const MachineRates& rates);

}  // namespace kestrel::bench
