// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/random.h"

namespace kestrel::sim::landscape {

// Smooth random numbers over the plane: 0 to 1 on a lattice of step 1 that repeats after 256 steps, smooth
// between.
class Noise {
 public:
  Noise(std::uint64_t seed, std::string_view name) : lattice_(kSize * kSize) {
    RandomStream random(seed, name);
    for (float& v : lattice_) v = static_cast<float>(random.Uniform(0, 1));
  }

  float At(float x, float y) const {
    // The whole number below, without a call into the library.
    const auto below_it = [](float t) {
      const int cut = static_cast<int>(t);
      return cut - (t < static_cast<float>(cut) ? 1 : 0);
    };
    const auto smooth = [](float t) { return t * t * (3 - 2 * t); };
    const int column = below_it(x), row = below_it(y);
    const float u = smooth(x - static_cast<float>(column)), v = smooth(y - static_cast<float>(row));
    const unsigned i = static_cast<unsigned>(column), j = static_cast<unsigned>(row);
    const float* low = &lattice_[(j % kSize) * kSize];
    const float* high = &lattice_[((j + 1) % kSize) * kSize];
    const unsigned a = i % kSize, b = (i + 1) % kSize;
    const float below = low[a] + u * (low[b] - low[a]), above = high[a] + u * (high[b] - high[a]);
    return below + v * (above - below);
  }

  // Octaves of half the size and half the height each; mean 1/2, mostly within 0.2 to 0.8.
  float Fractal(float x, float y, int octaves) const { return Sum<false>(x, y, octaves, 0, 0); }

  // The same where it lies between low and high; otherwise any number beyond the one that it is beyond. Most places are
  // so after an octave or two, since the others together are as high as the last one.
  float Fractal(float x, float y, int octaves, float low, float high) const {
    return Sum<true>(x, y, octaves, low, high);
  }

 private:
  static constexpr unsigned kSize = 256;

  template <bool bounded>
  float Sum(float x, float y, int octaves, float low, float high) const {
    constexpr float kRoom = 1e-4f;  // for what rounding may do
    float sum = 0, height = 0.5f, whole = 0;
    const float all = 1 - 1.0f / static_cast<float>(1 << octaves);
    for (int k = 0; k < octaves; ++k) {
      sum += height * At(x, y);
      whole += height;
      if constexpr (bounded) {
        if (sum + (all - whole) < (low - kRoom) * all) return low - 1;
        if (sum > (high + kRoom) * all) return high + 1;
      }
      height *= 0.5f;
      // Turned by an angle without pattern, so that the lattices of the octaves do not lie on each other.
      const float turned = 1.6f * x - 1.2f * y + 17.3f;
      y = 1.2f * x + 1.6f * y + 31.7f;
      x = turned;
    }
    return whole > 0 ? sum / whole : 0.5f;
  }

  std::vector<float> lattice_;
};

// 0 below low, 1 above high, smooth between.
inline float Step(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

// The height that Fractal() exceeds over about so much of the plane.
inline float Threshold(double share) {
  return share <= 0   ? 2.0f
         : share >= 1 ? -1.0f
                      : static_cast<float>(0.5 - 0.07 * std::log(share / (1 - share)));
}

// A number in [0, 1) for a pair of whole ones.
inline float Hashed(int i, int j, std::uint64_t salt) {
  const std::uint64_t key =
      static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32 | static_cast<std::uint32_t>(j);
  return static_cast<float>(RandomStream::Mix(key ^ RandomStream::Mix(salt)) >> 40) / 16777216.0f;
}

}  // namespace kestrel::sim::landscape
