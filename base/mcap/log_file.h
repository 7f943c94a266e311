// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

// What an MCAP file holds, for who writes one and who reads one. Times are ns since an epoch that the log's
// users know: here the beginning of a flight, or 1970.
namespace kestrel::mcap {

// How the messages of a channel are to be decoded. An empty encoding: there is no schema.
struct Schema {
  std::string name;      // "sensor_msgs/msg/Image"
  std::string encoding;  // "ros2msg", "jsonschema", ...
  std::string data;
  bool operator==(const Schema&) const = default;
};

struct Channel {
  std::string topic;             // "/camera/image_raw"
  std::string message_encoding;  // "cdr", "json", ...
  Schema schema;
  std::map<std::string, std::string> metadata = {};
  bool operator==(const Channel&) const = default;
};

struct Message {
  const Channel* channel = nullptr;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  std::uint64_t publish_time_ns = 0;
  std::string_view data;
};

// A file within the file.
struct Attachment {
  std::string name, media_type;
  std::uint64_t log_time_ns = 0;
  std::string data;
};

}  // namespace kestrel::mcap
