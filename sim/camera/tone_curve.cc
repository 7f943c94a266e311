// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/tone_curve.h"

#include <bit>
#include <cmath>
#include <limits>

namespace kestrel::sim {
namespace {

// Light from 2^-24 to 256 in stretches of a 512th of itself: the upper bits of a float number them. No
// stretch holds two thresholds while gamma is 1 or more: near white two thresholds are gamma / 255 of the
// light apart, in the dark more.
constexpr int kDropped_bits = 23 - 9;
constexpr float kMinLight = 0x1p-24f, kMaxLight = 255;
constexpr std::uint32_t kFirst = std::bit_cast<std::uint32_t>(kMinLight) >> kDropped_bits;
constexpr std::uint32_t kLast = std::bit_cast<std::uint32_t>(kMaxLight) >> kDropped_bits;

}  // namespace

ToneCurve::ToneCurve(double gamma, int bits) : straight_(gamma == 1) {
  const int levels = 1 << bits;
  for (int b = 0; b < 256; ++b)
    light_[b] = static_cast<float>(straight_ ? b : 255 * std::pow(b / 255.0, gamma));
  for (int level = 0; level < levels; ++level) {
    byte_.push_back(static_cast<std::uint8_t>(std::lround(255.0 * level / (levels - 1))));
    threshold_.push_back(
        level == 0 ? 0 : static_cast<float>(255 * std::pow((level - 0.5) / (levels - 1), gamma)));
  }
  threshold_.push_back(std::numeric_limits<float>::infinity());
  for (std::uint32_t stretch = kFirst; stretch <= kLast; ++stretch) {
    const float lower_end = std::bit_cast<float>(stretch << kDropped_bits);
    std::uint8_t level = first_guess_.empty() ? 0 : first_guess_.back();
    while (lower_end >= threshold_[level + 1]) ++level;
    first_guess_.push_back(level);
  }
}

void ToneCurve::Decode(const std::uint8_t* bytes, float factor, float* light, std::size_t count) const {
  if (straight_) {
    for (std::size_t i = 0; i < count; ++i) light[i] = factor * static_cast<float>(bytes[i]);
  } else {
    for (std::size_t i = 0; i < count; ++i) light[i] = factor * light_[bytes[i]];
  }
}

void ToneCurve::Encode(const float* light, std::uint8_t* bytes, std::size_t count) const {
  if (straight_) {
    const float levels = static_cast<float>(byte_.size()), scale = (levels - 1) / 255;
    for (std::size_t i = 0; i < count; ++i) {
      const float level = light[i] * scale + 0.5f;
      bytes[i] =
          static_cast<std::uint8_t>(static_cast<int>(level > 0 ? level < levels ? level : levels - 1 : 0));
    }
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const float x = light[i] > kMinLight ? light[i] < kMaxLight ? light[i] : kMaxLight : kMinLight;
      const std::uint8_t guess = first_guess_[(std::bit_cast<std::uint32_t>(x) >> kDropped_bits) - kFirst];
      bytes[i] = static_cast<std::uint8_t>(guess + (x >= threshold_[guess + 1]));
    }
  }
  if (byte_.size() == 256) return;
  for (std::size_t i = 0; i < count; ++i) bytes[i] = byte_[bytes[i]];
}

}  // namespace kestrel::sim
