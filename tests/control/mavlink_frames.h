// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "control/wire/mavlink_messages.h"

// Frames and messages to test with.
namespace kestrel::control::wire::mavlink {

// Values and the frame that node-mavlink makes of them.
struct Vector {
  Message message;
  std::string_view hex;
  struct {
    std::uint8_t version;
    bool is_signed;
    std::uint8_t sequence, system, component;
  } header;
};
const std::vector<Vector>& Vectors();
Bytes FromHex(std::string_view hex);

template <std::size_t n = 50>
std::array<char, n> Text(std::string_view text) {
  std::array<char, n> chars{};
  std::ranges::copy(text, chars.begin());
  return chars;
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// A frame by its bytes, when the bytes are no codec's.
inline Bytes WithChecksum(Bytes frame, std::uint8_t crc_extra) {
  std::uint16_t crc = 0xFFFF;  // bit by bit, by the definition: reflected 0x1021
  const auto add = [&crc](std::uint8_t byte) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit)
      crc = static_cast<std::uint16_t>(crc & 1 ? crc >> 1 ^ 0x8408 : crc >> 1);
  };
  for (std::size_t i = 1; i < frame.size(); ++i) add(frame[i]);
  add(crc_extra);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
  return frame;
}

}  // namespace kestrel::control::wire::mavlink
