// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <string_view>

#include "control/wire/bytes.h"
#include "control/wire/crc16.h"

namespace kestrel::control::wire {
namespace {

TEST(WireBytes, BothOrdersAreAsWritten) {
  Bytes bytes;
  Append(bytes, std::uint16_t{0x1234});
  Append(bytes, std::uint16_t{0x1234}, std::endian::big);
  Append(bytes, -2, std::endian::big);
  Append(bytes, 1.0F);
  EXPECT_EQ(bytes, (Bytes{0x34, 0x12, 0x12, 0x34, 0xFF, 0xFF, 0xFF, 0xFE, 0, 0, 0x80, 0x3F}));
}

TEST(WireBytes, WhatIsAppendedIsTaken) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    Bytes bytes;
    Append(bytes, std::numeric_limits<std::int64_t>::min(), order);
    Append(bytes, std::uint8_t{200}, order);
    Append(bytes, -1.5e-300, order);
    Reader reader(bytes, order);
    EXPECT_EQ(reader.Read<std::int64_t>(), std::numeric_limits<std::int64_t>::min());
    EXPECT_EQ(reader.Read<std::uint8_t>(), 200);
    EXPECT_EQ(reader.Read<double>(), -1.5e-300);
    EXPECT_EQ(reader.left(), 0U);
    EXPECT_TRUE(reader.Good());
  }
}

TEST(WireBytes, BeyondTheEndIsNothingAndSaid) {
  const Bytes bytes{1, 2, 3};
  Reader reader(bytes);
  reader.Read<std::uint16_t>();
  EXPECT_TRUE(reader.Good());
  EXPECT_EQ(reader.Read<std::uint16_t>(), 0);
  EXPECT_FALSE(reader.Good());
  EXPECT_EQ(reader.Read<std::uint8_t>(), 0);  // not what was left over
  Reader skipping(bytes);
  skipping.Skip(4);
  EXPECT_FALSE(skipping.Good());
}

std::uint16_t Crc(std::uint16_t begin, std::string_view text) {
  Crc16 crc(begin);
  for (const char c : text) crc.Add(static_cast<std::uint8_t>(c));
  return crc.sum();
}

TEST(Crc16, TheCheckValuesOfBothProtocols) {
  EXPECT_EQ(Crc(0xFFFF, "123456789"), 0x6F91);
  EXPECT_EQ(Crc(0x00FF, "123456789"), 0x9DB8);
}

}  // namespace
}  // namespace kestrel::control::wire
