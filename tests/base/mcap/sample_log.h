// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/mcap/reader.h"
#include "base/mcap/writer.h"

namespace kestrel::mcap {

// A message by itself, whatever it was read from.
struct Copy {
  std::string topic;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  std::string data;
  auto operator<=>(const Copy&) const = default;
};

inline std::vector<Copy> AllOf(Reader& reader) {
  std::vector<Copy> all;
  while (const std::optional<Message> message = reader.Next())
    all.push_back(
        {message->channel->topic, message->sequence, message->log_time_ns, std::string(message->data)});
  return all;
}

inline const Channel kFast{"/fast", "cdr", {"pkg/msg/Fast", "ros2msg", "float64 x"}, {{"rate", "500"}}};
inline const Channel kSlow{"/slow", "json", {}, {}};

// Some messages of two channels in several chunks, an attachment and metadata; what was written, in the order
// of the times.
inline std::vector<Copy> WriteSample(const std::filesystem::path& file, Compression compression,
                                     int messages = 40, std::size_t chunk_bytes = 400) {
  Writer writer(file, {"ros2", compression, chunk_bytes});
  const std::uint16_t fast = writer.Add(kFast), slow = writer.Add(kSlow);
  std::vector<Copy> written;
  std::uint32_t slow_sequence = 0;
  for (int i = 0; i < messages; ++i) {
    const auto t_ns = static_cast<std::uint64_t>(i) * 2'000'000 + 1'000'000'000;
    written.push_back(
        {"/fast", static_cast<std::uint32_t>(i), t_ns, std::string(16, static_cast<char>('a' + i % 26))});
    writer.Write(fast, t_ns, written.back().data);
    if (i % 4 != 0) continue;
    written.push_back({"/slow", slow_sequence++, t_ns, "{\"i\": " + std::to_string(i) + "}"});
    writer.Write(slow, t_ns, written.back().data);
    if (i == 8) writer.Attach({"notes.txt", "text/plain", t_ns, "what was attached"});
    if (i == 12) writer.AddMetadata("flight", {{"seed", "7"}, {"scenario", "landing"}});
  }
  writer.Close();
  return written;
}

}  // namespace kestrel::mcap
