// SPDX-License-Identifier: Apache-2.0
#include "base/mcap/wire.h"

#include <fmt/format.h>

#include <boost/crc.hpp>
#include <limits>

namespace kestrel::mcap {
namespace {

std::uint32_t LengthOf(std::string_view text) {
  if (text.size() > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error(fmt::format("{} bytes are too many for a text of MCAP", text.size()));
  return static_cast<std::uint32_t>(text.size());
}

}  // namespace

void PutText(std::string& to, std::string_view text) {
  Put(to, LengthOf(text));
  to += text;
}

void PutMap(std::string& to, const std::map<std::string, std::string>& map) {
  std::string entries;
  for (const auto& [key, value] : map) {
    PutText(entries, key);
    PutText(entries, value);
  }
  PutText(to, entries);
}

void PutRecord(std::string& to, Op op, std::string_view content) {
  Put(to, static_cast<std::uint8_t>(op));
  Put(to, static_cast<std::uint64_t>(content.size()));
  to += content;
}

std::uint32_t Crc32(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

std::string_view Cursor::Bytes(std::uint64_t count, const char* name) {
  if (count > left_.size())
    throw Malformed(fmt::format("{} has {} bytes where {} are left", name, count, left_.size()));
  const std::string_view bytes = left_.substr(0, count);
  left_.remove_prefix(count);
  return bytes;
}

std::map<std::string, std::string> Cursor::Map(const char* name) {
  std::map<std::string, std::string> map;
  for (Cursor entries(Text(name)); entries.left() > 0;) {
    const std::string_view key = entries.Text(name);
    map.emplace(key, entries.Text(name));
  }
  return map;
}

}  // namespace kestrel::mcap
