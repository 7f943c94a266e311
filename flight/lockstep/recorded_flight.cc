// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/recorded_flight.h"

#include "records/telemetry/flight_mode.h"
#include "records/video/drawn_view.h"

namespace kestrel::flight {
namespace {

// Who steps it is not in the scenario, so that no command flies it again.
LoadedScenario SteppedByOthers(LoadedScenario loaded) {
  loaded.again.clear();
  return loaded;
}

}  // namespace

RecordedFlight::RecordedFlight(const Sim& sim, const Observation& first, const std::filesystem::path& folder,
                               bool video)
    : sim_(sim),
      records_(folder, SteppedByOthers(sim.scenario()), sim.simulator(),
               SceneOf(sim.scenario(), sim.simulator()), video) {
  WriteImage(first);
}

void RecordedFlight::Write(const Observation& observation) {
  // The last row's setpoint is still to come.
  if (!sim_.rows().empty()) WriteRows(sim_.rows().size() - 1);
  WriteImage(observation);
}

void RecordedFlight::WriteRows(std::size_t until) {
  for (; written_ < until; ++written_) records_.Write(sim_.rows()[written_], sim_.simulator());
}

void RecordedFlight::WriteImage(const Observation& observation) {
  if (records_.recorder().wants_images() && observation.frame && !observation.frame->image.empty())
    records_.recorder().WriteImage(
        records::DrawnView(*observation.frame, sim_.t_s(), records::kSimulatorMode));
}

records::Summary RecordedFlight::Finish(const std::string& error) {
  records::Summary summary = SummaryOf(sim_, error);
  try {
    WriteRows(sim_.rows().size());
  } catch (const std::runtime_error& e) {
    if (summary.error.empty()) summary.error = e.what();
    summary.complete = summary.passed = false;
  }
  return records_.Finish(summary, sim_.simulator());
}

records::Summary SummaryOf(const Sim& sim, const std::string& error) {
  records::Summary summary = sim.Summarise();
  summary.error = error;
  if (!error.empty()) summary.complete = summary.passed = false;
  return summary;
}

}  // namespace kestrel::flight
