// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/file/writer_lock.h"
#include "flight/flight_plan.h"
#include "flight/live/live.h"
#include "mission/mission.h"
#include "records/recorder.h"
#include "records/telemetry/event_log.h"

namespace kestrel::app {

// A flight that is seen again, as that of a real one, of which nobody knows the truth: its folder, and what its viewers
// see. Its times are those of the images, from the first one. Throws std::runtime_error with the file and the reason;
// InputError where another process writes to that folder.
class ReplayRecords {
 public:
  // folder, live: none, null: none is written, nobody sees it.
  ReplayRecords(const std::optional<std::filesystem::path>& folder, flight::Live* live,
                const flight::LoadedPlan& plan, double rate_hz);
  // Waits as viewers wish.
  void Write(const vision::Frame& frame, const control::VehicleState& state,
             const mission::Decision& decision, const mission::Mission& mission);
  // Returns the name of its page, or its own where there is none; empty: there is no folder.
  std::string Finish(const std::string& outcome, bool passed, double wall_s);

 private:
  struct Folder {
    Folder(const std::filesystem::path& where, const flight::LoadedPlan& plan, double rate_hz);
    std::filesystem::path where;
    WriterLock lock;
    records::Recorder recorder;
  };
  void BeginLive(double rate_hz);

  flight::Live* live_;
  const flight::LoadedPlan& plan_;
  std::optional<Folder> folder_;
  std::optional<records::EventLog> events_;
  std::optional<double> first_s_;
  double last_s_ = 0;
};

}  // namespace kestrel::app
