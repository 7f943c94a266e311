// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bench/enhance/shaken_clip.h"

namespace kestrel::bench {

// The clips on which ways to stabilise are compared, ours and the peers': a hover, a transit, one that turns and climbs,
// and a transit whose rows are exposed one after the other, over 30 ms.
inline std::vector<ShakenClipOptions> StabiliseClips() {
  return {{.name = "hover"},
          {.name = "transit", .forward_m_s = 3},
          {.name = "turn", .forward_m_s = 1, .turn_rad_s = 0.15, .climb_m_s = 0.5},
          {.name = "rows", .forward_m_s = 3, .readout_s = 0.03}};
}

}  // namespace kestrel::bench
