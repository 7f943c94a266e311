// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/random.h"

namespace kestrel::sim {

// Normal random numbers for images, drawn once: each row of each frame reads them from a place of its own, so
// that no frame costs a million of them. What a row gets depends on seed, sequence and row alone.
template <class Number>
class NoiseTable {
 public:
  // of: makes the number to keep of one with mean 0 and deviation 1.
  template <class Function>
  NoiseTable(std::uint64_t seed, Function&& of) : seed_(RandomStream::Mix(seed)), numbers_(kSize) {
    RandomStream random(seed, "image noise");
    for (Number& n : numbers_) n = of(random.Normal());
  }
  NoiseTable() = default;  // empty
  bool empty() const { return numbers_.empty(); }

  // length numbers, at most half of kSize.
  const Number* Row(std::int64_t sequence, int row, std::size_t length) const {
    const std::uint64_t place =
        RandomStream::Mix(seed_ ^ RandomStream::Mix((static_cast<std::uint64_t>(sequence) << 20) +
                                                    static_cast<std::uint64_t>(row)));
    return numbers_.data() + place % (kSize - length);
  }

 private:
  static constexpr std::size_t kSize = std::size_t{1} << 18;
  std::uint64_t seed_ = 0;
  std::vector<Number> numbers_;
};

}  // namespace kestrel::sim
