// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/mcap/file_bytes.h"
#include "base/mcap/log_file.h"

namespace kestrel::mcap {

// What is where in a file: by its summary, or by going through it.
struct Summary {
  struct Chunk {
    std::uint64_t from_ns = 0, until_ns = 0, offset = 0, length = 0;
    std::vector<std::uint16_t> channels;  // that have messages in it; none: not told
  };
  struct Record {
    std::uint64_t length = 0;  // all of it
    std::string name;
  };

  // Of the contents of records. Throw Malformed.
  void TakeSchema(std::string_view content);
  void TakeChannel(std::string_view content);
  void TakeAttachment(std::uint64_t offset, std::string_view content);
  void TakeMetadata(std::uint64_t offset, std::string_view content);
  void CountMessage(std::uint64_t log_time_ns);

  bool indexed = false;  // its chunks are those of the file, in the order of their times
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<Chunk> chunks;
  std::map<std::uint64_t, Record> attachments, metadata;  // by offset
  std::uint64_t messages = 0, first_ns = 1, last_ns = 0;
};

// The summary that a file has at its end; none: it has none that would do. Throws Malformed where that is
// because it is damaged or was cut off.
std::optional<Summary> ReadSummary(const FileBytes& file);

}  // namespace kestrel::mcap
