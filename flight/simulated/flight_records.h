// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "base/file/writer_lock.h"
#include "flight/simulated/scenario.h"
#include "records/recorder.h"
#include "records/telemetry/event_log.h"

namespace kestrel::flight {

// The folder of a flight in the simulator: what the Recorder writes, events.log, scenario.yaml. Throws
// std::runtime_error with the file and the reason, but for Finish; InputError where another process writes to
// that folder.
class FlightRecords {
 public:
  FlightRecords(const std::filesystem::path& folder, const LoadedScenario& loaded, bool video);

  void Write(const records::LogRow& row, const sim::Simulator& simulator);
  // Of events.log, between rows.
  void Note(double t_s, std::string_view what, std::string_view is) { events_.Line(t_s, what, is); }
  records::Recorder& recorder() { return recorder_; }

  // Ends all files. What fails here makes the flight one that broke off; returns what summary.json then says.
  // Throws only if that cannot be written.
  records::Summary Finish(records::Summary summary, const sim::Simulator& simulator);

 private:
  void WriteChanges(const sim::Simulator& simulator);

  WriterLock lock_;  // before anything is written
  records::Recorder recorder_;
  records::EventLog events_;
  std::size_t conditions_written_ = 0, states_written_ = 0;
};

}  // namespace kestrel::flight
