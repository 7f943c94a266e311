// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kestrel::sim {

// Between the bytes of an image and light, on a scale on which white is 255 in both. A byte b holds the light
// 255 (b / 255)^gamma. With fewer than 8 bits a byte takes 2^bits values only, evenly spread from 0 to 255.
class ToneCurve {
 public:
  ToneCurve(double gamma, int bits);

  // The light of bytes, times a factor.
  void Decode(const std::uint8_t* bytes, float factor, float* light, std::size_t count) const;
  // The byte whose light is nearest on the curve (halves go up); light beyond black and white is clipped.
  void Encode(const float* light, std::uint8_t* bytes, std::size_t count) const;

 private:
  bool straight_;                          // gamma is 1
  std::array<float, 256> light_;           // of a byte
  std::vector<std::uint8_t> byte_;         // of a level, of which there are 2^bits
  std::vector<float> threshold_;           // the least light of a level, and infinity at the end
  std::vector<std::uint8_t> first_guess_;  // level at the lower end of a stretch of light; see Encode
};

}  // namespace kestrel::sim
