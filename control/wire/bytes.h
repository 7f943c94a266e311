// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

// Numbers on a wire: integers and IEEE floats in either byte order, whatever this machine's is.
namespace kestrel::control::wire {

using Bytes = std::vector<std::uint8_t>;

template <class T>
concept Number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool> && sizeof(T) <= 8;

template <Number T>
void Append(Bytes& bytes, T value, std::endian order = std::endian::little) {
  auto raw = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  for (const std::uint8_t byte : raw) bytes.push_back(byte);
}

// Reads one number after the other. What is beyond the end is 0 and leaves Good() false: callers check once,
// at the end.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes, std::endian order = std::endian::little)
      : bytes_(bytes), order_(order) {}

  template <Number T>
  T Read() {
    std::array<std::uint8_t, sizeof(T)> raw{};
    if (left() < sizeof(T)) {
      good_ = false, at_ = bytes_.size();
      return T{};
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), sizeof(T), raw.begin());
    at_ += sizeof(T);
    if (order_ != std::endian::native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  void Skip(std::size_t count) {
    good_ = good_ && count <= left();
    at_ = std::min(bytes_.size(), at_ + std::min(count, left()));
  }

  std::size_t left() const { return bytes_.size() - at_; }
  bool Good() const { return good_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::endian order_;
  std::size_t at_ = 0;
  bool good_ = true;
};

}  // namespace kestrel::control::wire
