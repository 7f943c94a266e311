// SPDX-License-Identifier: Apache-2.0
#include "records/mcap/flight_mcap.h"

#include <algorithm>
#include <utility>

namespace kestrel::records {
namespace {

// Times before the flight's are none that a log has.
std::uint64_t LogTime(std::int64_t ns) { return static_cast<std::uint64_t>(std::max<std::int64_t>(0, ns)); }

}  // namespace

FlightMcap::FlightMcap(const std::filesystem::path& file, FlightMessageOptions options)
    : FlightMessages(std::move(options)), writer_(file, {.profile = "ros2"}) {}

void FlightMcap::WriteScenario(const std::string& yaml, const std::map<std::string, std::string>& about) {
  writer_.AddMetadata("kestrel", about);
  writer_.Attach({"scenario.yaml", "application/yaml", 0, yaml});
}

void FlightMcap::WriteCdr(const std::string& topic, const char* type, std::int64_t log_time_ns,
                          std::int64_t stamp_ns, const std::string& cdr) {
  const auto [channel, added] = channels_.try_emplace(topic, 0);
  if (added) channel->second = writer_.Add({topic, "cdr", {type, "ros2msg", ros::SchemaOf(type)}});
  writer_.Write(channel->second, LogTime(log_time_ns), LogTime(stamp_ns), cdr);
}

}  // namespace kestrel::records
