// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/mcap/reader.h"

namespace kestrel::vision {

// The topics of an MCAP whose messages are of one of these types of ROS 2 ("sensor_msgs/msg/Imu"), by name.
std::vector<std::string> TopicsOf(const mcap::Reader& reader, const std::vector<std::string>& types);

// Which of them is wanted: the one that is named, or the only one. `what` they have: "images". None: a mistake
// says which there are.
std::optional<std::string> TopicOf(const mcap::Reader& reader, const std::filesystem::path& file,
                                   const std::string& topic, const std::vector<std::string>& types,
                                   const std::string& what, Mistakes& mistakes);

// The stamps of a topic's messages, as they are read. What is wrong with them is a mistake, of the first 20 by
// itself.
class McapStamps {
 public:
  McapStamps(std::filesystem::path file, std::string topic, Mistakes& mistakes)
      : file_(std::move(file)), topic_(std::move(topic)), mistakes_(mistakes) {}

  // Of the next message, whose data begin with a header.
  void Add(const mcap::Message& message);
  // What is wrong with the message that was added last.
  void Wrong(const std::string& what);
  // After the last: those of the headers, or of the log where the headers have none.
  std::vector<std::int64_t> Take();
  // When each was logged.
  const std::vector<std::int64_t>& logged_ns() const { return logged_ns_; }
  // What is to be told of them and of the file.
  std::string Note(const mcap::Reader& reader, const std::string& what) const;

  std::string NameOf(std::size_t message) const;  // "flight.mcap: message 12 of /camera"

 private:
  std::filesystem::path file_;
  std::string topic_;
  Mistakes& mistakes_;
  std::vector<std::int64_t> stamps_ns_, logged_ns_;
  int wrong_ = 0;
  bool by_log_ = false;
};

}  // namespace kestrel::vision
