// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <spdlog/logger.h>

#include <filesystem>
#include <memory>
#include <string>

#include "scenarios/flight_log.h"

namespace kestrel {

// events.log of a run: a line, with the time of the flight, whenever a state changes its name: the phase of
// the flight plan, the target (tracked, found, chained, refused, lost), the autopilot's mode (hold: its
// setpoints went stale), its saturation, the touch-down.
class EventLog {
 public:
  explicit EventLog(const std::filesystem::path& folder);
  ~EventLog();
  void Write(const LogRow& row);
  void End(double t_s, const std::string& how);

 private:
  std::shared_ptr<spdlog::logger> log_;
  std::string phase_, target_, mode_;
  bool saturated_ = false, touching_ = false;
};

}  // namespace kestrel
