// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "flight/live/live.h"
#include "flight/simulated/changes.h"
#include "flight/simulated/scenario.h"
#include "flight/simulated/view/view_options.h"
#include "records/mcap/flight_mcap.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::flight {

struct RunOptions {
  std::optional<std::filesystem::path> folder;  // of the records; none: nothing is written
  bool video = true;
  std::function<bool(const records::LogRow&)> progress;  // after each frame; false breaks the run off
  bool images = false;                                   // recording.h, for replay
  std::optional<records::McapImages> mcap = {};          // flight.mcap with such images; none: there is none
  bool truth = false;                                    // truth_images.h, into its folder truth/
  bool events = false;                                   // event_files.h, into its folder events/
  // After each frame, for who wants to look at the world and changes nothing in it.
  std::function<void(const sim::Simulator&, const vision::Frame&)> watch = {};
  // After each frame and the decision on it, for who changes what the scenario lets change.
  std::function<void(Changes&)> change = {};
  std::optional<ViewOptions> view = {};  // the flight from outside, as view.mp4; none: it is not drawn
  Live* live = nullptr;  // shows it to viewers, who may pause and change it; null: nobody does
};

struct FlightResult {
  records::Summary summary;
  std::vector<records::LogRow> rows;
};

// Flies a scenario in the simulator. What breaks a run off (a state that is no number, a disk that is full)
// is in the summary's error. Throws std::runtime_error if it cannot even begin: no OpenGL context, no folder.
FlightResult RunFlight(const LoadedScenario& loaded, const RunOptions& options);

}  // namespace kestrel::flight
