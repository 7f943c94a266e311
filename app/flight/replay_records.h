// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/file/writer_lock.h"
#include "flight/flight_plan.h"
#include "mission/mission.h"
#include "records/recorder.h"
#include "records/telemetry/event_log.h"

namespace kestrel::app {

// The folder of a flight that was seen again: as that of a real one, of which nobody knows the truth. Its times are
// those of the images, from the first one. Throws std::runtime_error with the file and the reason; InputError where
// another process writes to that folder.
class ReplayRecords {
 public:
  ReplayRecords(const std::filesystem::path& folder, const flight::LoadedPlan& plan, double rate_hz);
  void Write(const vision::Frame& frame, const control::VehicleState& state,
             const mission::Decision& decision, const mission::Mission& mission);
  // Returns the name of its page, or its own where there is none.
  std::string Finish(const std::string& outcome, bool passed, double wall_s);

 private:
  std::filesystem::path folder_;
  WriterLock lock_;
  const flight::LoadedPlan& plan_;
  records::Recorder recorder_;
  records::EventLog events_;
  std::optional<double> first_s_;
  double last_s_ = 0;
};

}  // namespace kestrel::app
