// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "base/mcap/writer.h"
#include "base/nanoseconds.h"
#include "base/ros/schemas.h"
#include "records/mcap/flight_messages.h"

namespace kestrel::records {

// flight.mcap: a flight as ROS's and Foxglove's tools read it.
//
// Throws std::runtime_error with the file and the reason.
class FlightMcap final : public FlightMessages {
 public:
  FlightMcap(const std::filesystem::path& file, FlightMessageOptions options);

  // scenario.yaml, and what else a reader may want to know of the flight.
  void WriteScenario(const std::string& yaml, const std::map<std::string, std::string>& about);
  void Close() { writer_.Close(); }

 private:
  bool Wants(const std::string&, const char*) override { return true; }
  void WriteCdr(const std::string& topic, const char* type, std::int64_t log_time_ns, std::int64_t stamp_ns,
                const std::string& cdr) override;

  mcap::Writer writer_;
  std::map<std::string, std::uint16_t> channels_;  // by topic
};

}  // namespace kestrel::records
