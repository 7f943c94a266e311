// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "control/link/safe_autopilot.h"
#include "flight/flight_plan.h"
#include "flight/live/live.h"
#include "mission/mission.h"
#include "vision/capture/live_camera.h"

namespace kestrel::flight {

struct FlyOptions {
  control::SafetyLimits limits;
  bool pilot_untold = false;                    // as in PreFlightOptions
  bool dry_run = false;                         // no setpoint is sent
  bool checked = true;                          // the check list was met; a dry run goes on without
  std::optional<std::filesystem::path> folder;  // of the records; none: nothing is written
  bool video = true, images = false;            // images: for replay
  std::string aircraft;                         // text of aircraft.yaml, beside them; empty: none
  // The first lines of events.log: what it is flown with, and the check list.
  std::vector<std::pair<std::string, std::string>> flown_with;
  control::ReleaseLimits release;  // of the aircraft, at the end
  double max_s = 3600;
  const std::atomic<bool>* interrupted = nullptr;
  Live* live = nullptr;  // shows it to viewers, who cannot command it; null: nobody sees it
  // Each frame before the mission has it, on the flight's own thread; must be quick.
  std::function<void(const vision::Frame&)> seen = {};
  // Each frame of a flight, and each change of safety while none comes (with the last decision), on the
  // flight's own thread; must be quick.
  std::function<void(const control::VehicleState&, const mission::Decision&, const control::SafetyChange&)>
      progress;
  // What happens of itself and should be known at once, in words, on the flight's own thread; must be quick.
  std::function<void(const std::string&)> told = {};
};

struct FlyReport {
  // The mission's; "interrupted", "time is up", "camera ended"; who else had the aircraft at its end
  // (flight/hardware/control_monitor.h); of a dry run what it was and what was lost.
  std::string outcome;
  // What the flight is for, under the mission's own control. Of a dry run: the check list was met, and
  // neither images nor the state were lost.
  bool accomplished = false;
  std::string error;    // of the records; empty: none. The flight goes on without them
  std::string lag;      // of an autopilot that followed later than the gains allow; empty: none did
  std::string release;  // how the aircraft was let go (control/safety/release.h); empty: a dry run
  std::int64_t frames = 0, images_overwritten = 0, records_dropped = 0;
  // From when an image was there to when its setpoint was handed to the link.
  double mean_ms = 0, p99_ms = 0;
};

// What a real aircraft asks of a mission and a simulated one does not.
void CheckDeclared(const mission::Mission& mission, const std::string& name, Mistakes& mistakes);

// Flies a mission on what is real: the same loop as in the simulator, through the safety layer, with records
// written by another thread that a flight never waits for. However it ends, the aircraft is made to stand
// still before the wire falls silent. Nothing here throws in flight.
FlyReport FlyAircraft(const LoadedPlan& plan, vision::LiveCamera& camera, control::AutopilotLink& link,
                      const FlyOptions& options);

// The folder of a flight that was not flown: what it would have been flown with, and why it was not. Throws
// std::runtime_error with the file and the reason.
void RecordNotFlown(const LoadedPlan& plan, const FlyOptions& options, const std::string& why);

}  // namespace kestrel::flight
