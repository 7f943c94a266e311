// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file/files.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::records {

using EventListener = std::function<void(double t_s, std::string_view what, std::string_view is)>;

// events.log of a run: a line, with the time of the flight, whenever a state changes its name: the phase of
// the flight plan, the target (tracked, found, chained, refused, lost, frozen), the autopilot's mode (hold:
// its setpoints went stale), its saturation, the attitude it flies by, the faults of that, of the camera, of
// sensors and actuators, what its navigation makes of its sensors, the touch-down. Each line is with the
// system at once: whatever becomes of the program, what it wrote is there. Throws std::runtime_error with the
// file and the reason.
class EventLog {
 public:
  explicit EventLog(const std::filesystem::path& folder) : file_(folder / "events.log") {}
  EventLog() = default;  // of no file: for who is told
  // From now on this too is told each line, before its file is.
  void Tell(EventListener listener) { listeners_.push_back(std::move(listener)); }
  // In the order of time.
  void Write(const LogRow& row);
  void WriteCamera(double t_s, std::string_view condition);
  void Line(double t_s, std::string_view what, std::string_view is);
  void End(double t_s, std::string_view how);

 private:
  std::optional<PartFile> file_;
  std::vector<EventListener> listeners_;
  std::string phase_, target_, mode_, camera_ = "ok";
  bool saturated_ = false, touching_ = false, aided_ = false, attitude_failed_ = false;
};

}  // namespace kestrel::records
