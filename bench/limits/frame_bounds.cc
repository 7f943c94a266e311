// SPDX-License-Identifier: Apache-2.0
#include "bench/limits/frame_bounds.h"

namespace kestrel::bench {
namespace {

constexpr double kRaysAtAnEdge = 8;

// Floats of a direction, three bytes of the picture; a texel for each pixel, since its level has them so wide.
constexpr double kBytesOfAPixel = 3 * 4 + 3, kBytesOfATexel = 3;
constexpr double kReadsOfATexel = 2;

// Additions and multiplications. To meet a plane: the direction into its frame 15, the distance 2, the point 6.
constexpr double kToMeet = 23;
// To colour: light from one direction 5, as large for three channels 9; rounded and stored 6.
constexpr double kToColour = 20;
// A texel besides: both neighbours' rays in the thing's frame 30, how far they move the point 20, so many texels 11;
// where it is 12, between four texels of three channels 24.
constexpr double kToTexture = 97;

}  // namespace

FrameBounds BoundsOf(const FrameContent& content, const MachineRates& rates) {
  const double bytes = content.pixels * kBytesOfAPixel + content.textured * kBytesOfATexel;
  const double operations = content.pixels * (kToMeet + kToColour) + content.textured * kToTexture +
                            content.at_edges * (kRaysAtAnEdge * kToMeet + kToColour);
  return {.memory_ms = 1e-6 * bytes / RateFor(rates, bytes).read_gb_s,
          .random_ms = 1e-3 * content.textured * kReadsOfATexel / rates.memory.front().random_reads_per_us,
          .arithmetic_ms = 1e-6 * operations / rates.multiply_adds_gflop_s};
}

}  // namespace kestrel::bench
