// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/crc.hpp>
#include <cstdint>
#include <span>

// The check sum of MAVLink (CRC-16/MCRF4XX) and of AscTec's low-level processor, which is the same but for
// what it begins with.
namespace kestrel::control::wire {

// begin, reflected as both protocols write it: 0xFFFF for MAVLink, 0x00FF for AscTec.
class Crc16 {
 public:
  explicit Crc16(std::uint16_t begin) : crc_(Reversed(begin)) {}
  void Add(std::span<const std::uint8_t> bytes) { crc_.process_bytes(bytes.data(), bytes.size()); }
  void Add(std::uint8_t byte) { crc_.process_byte(byte); }
  std::uint16_t sum() const { return static_cast<std::uint16_t>(crc_.checksum()); }

 private:
  // Boost takes the register unreflected.
  static std::uint16_t Reversed(std::uint16_t value) {
    std::uint16_t reversed = 0;
    for (int bit = 0; bit < 16; ++bit)
      reversed = static_cast<std::uint16_t>(reversed << 1 | (value >> bit & 1));
    return reversed;
  }
  boost::crc_optimal<16, 0x1021, 0, 0, true, true> crc_;
};

}  // namespace kestrel::control::wire
