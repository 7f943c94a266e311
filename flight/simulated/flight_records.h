// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/file/writer_lock.h"
#include "flight/mcap/carried_topics.h"
#include "flight/simulated/changes.h"
#include "flight/simulated/scenario.h"
#include "records/mcap/flight_mcap.h"
#include "records/page/flight_subject.h"
#include "records/recorder.h"
#include "records/telemetry/event_log.h"

namespace kestrel::flight {

// What a page tells of such a flight. simulator: at its begin.
records::FlightSubject SubjectOf(const LoadedScenario& loaded, const sim::Simulator& simulator);

// Its scene.glb; empty, and standard error says why: it cannot be made.
std::string SceneOf(const LoadedScenario& loaded, const sim::Simulator& simulator);

// The folder of a flight in the simulator: what the Recorder writes, events.log, scenario.yaml, page.json, if
// asked for flight.mcap. Throws std::runtime_error with the file and the reason, but for Finish; InputError where
// another process writes to that folder.
class FlightRecords {
 public:
  // simulator: at the begin of the flight; scene_glb: of it. view: there is a video from outside too (flight/simulated/view), with
  // which that on board shares the size of the page.
  FlightRecords(const std::filesystem::path& folder, const LoadedScenario& loaded,
                const sim::Simulator& simulator, const std::string& scene_glb, bool video, bool view = false);

  // From now on flight.mcap is written too. parts: what the mission was made from.
  void AddMcap(records::McapImages images, const LoadedScenario& loaded, const mission::MissionParts& parts);

  // From now on this too is told each line of events.log.
  void Tell(records::EventListener listener) { events_.Tell(std::move(listener)); }

  // image: of the row's frame, for flight.mcap; empty: there is none.
  void Write(const records::LogRow& row, const sim::Simulator& simulator, const cv::Mat& image = {});
  // Of events.log, between rows.
  void Note(double t_s, std::string_view what, std::string_view is) { events_.Line(t_s, what, is); }
  // A change in flight; flown: the scenario by which it is flown again.
  void Write(const MadeChange& change, const Scenario& flown);
  // The command that flies it again, from scenario.yaml after a change by hand; empty: none does.
  const std::string& again() const { return again_; }
  records::Recorder& recorder() { return recorder_; }

  // Ends all files. What fails here makes the flight one that broke off; returns what summary.json then says.
  // Throws only if that cannot be written.
  records::Summary Finish(records::Summary summary, const sim::Simulator& simulator);

 private:
  void WriteChanges(const sim::Simulator& simulator);

  std::filesystem::path folder_;
  WriterLock lock_;  // before anything is written
  records::Recorder recorder_;
  records::EventLog events_;
  std::unique_ptr<records::FlightMcap> mcap_;  // null: not asked for
  std::optional<CarriedTopics> carried_;       // as mcap_
  std::string again_;
  std::size_t conditions_written_ = 0, states_written_ = 0;
};

}  // namespace kestrel::flight
