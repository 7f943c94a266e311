// SPDX-License-Identifier: Apache-2.0
#include "app/flight/replay_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "app/flight/recorded_states.h"
#include "app/flight/replay_records.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/stopwatch.h"
#include "flight/flight_plan.h"
#include "records/recording.h"
#include "records/telemetry/flight_mode.h"
#include "records/video/drawn_view.h"
#include "records/video/video.h"
#include "vision/capture/folder_source.h"
#include "vision/capture/recorded/mcap_images.h"
#include "vision/capture/recorded/recorded_images.h"

namespace kestrel::app {
namespace {

// The number of the newest state that was logged when an image was: what its flight code knew then. None: none was.
std::optional<std::size_t> StateAt(const RecordedStates& recorded, std::int64_t logged_ns) {
  const auto after = std::upper_bound(recorded.logged_ns.begin(), recorded.logged_ns.end(), logged_ns);
  const auto count = static_cast<std::size_t>(after - recorded.logged_ns.begin());
  return count == 0 ? std::nullopt : std::optional(count - 1);
}

std::string Row(std::int64_t image, std::int64_t stamp_ns, double t_s,
                const records::RecordedDecision& decision) {
  std::string row = fmt::format("{},{},{:.9f},{},{},{}", image, stamp_ns, t_s, decision.phase,
                                decision.target, decision.outcome);
  for (const auto& number : decision.numbers) row += number ? fmt::format(",{}", *number) : ",";
  return row + '\n';
}

}  // namespace

void ReplayLog(const ReplayArguments& a) {
  Mistakes mistakes;
  if (a.scenario.empty())
    mistakes.Add("--scenario", "", "not given: which mission is to see the recording",
                 "valid: a scenario's name or file");
  CheckWritableFile(a.csv, "--csv", mistakes);
  CheckWritableFile(a.video, "--video", mistakes);
  CheckWritableFolder(a.out, "--out", mistakes);
  std::optional<flight::LoadedPlan> loaded;
  try {
    if (!a.scenario.empty()) loaded = flight::LoadPlan(a.scenario, a.overrides);
  } catch (const InputError& e) {
    mistakes.Add(e);
  }
  if (loaded && loaded->plan.flight.type().needs_ground_camera)
    mistakes.Add("--scenario", "", fmt::format("'{}' flies by a camera on the ground too", a.scenario),
                 "valid: a flight by the camera on board alone");
  const auto images =
      std::make_shared<const vision::RecordedImages>(vision::OpenMcapImages(a.folder, a.topic, mistakes));
  const RecordedStates states =
      images->size() > 0 ? ReadRecordedStates(a.folder, a.state_topic, mistakes) : RecordedStates();
  const std::optional<flight::LiveOptions> of_live = ReadLive(a.live, mistakes);
  mistakes.ThrowIfAny();

  const flight::FlightPlan& plan = loaded->plan;
  const auto source = vision::FolderSource(
      {.images = a.folder, .opened = images, .size = {}, .colour = plan.image.colour, .bits = a.bits})();
  if (!source->Open()) throw InputError(a.folder, source->Error());
  const std::unique_ptr<mission::Mission> mission = plan.flight->Make(loaded->parts);
  const mission::MissionType& type = plan.flight.type();
  const double rate_hz = images->Rate_hz() > 0 ? images->Rate_hz() : plan.image.rate_hz;
  std::optional<records::Video> video;
  if (!a.video.empty()) video.emplace(a.video, rate_hz);
  const std::unique_ptr<flight::Live> live = MakeLive(of_live);
  PrintLive(live.get());
  ReplayRecords records(OutOf(a), live.get(), *loaded, rate_hz);
  std::string csv = fmt::format("image,stamp_ns,t_s,phase,target,outcome,{}\n",
                                fmt::join(records::RecordedNumbers(type), ","));
  const auto begun = std::chrono::steady_clock::now();
  std::size_t unreadable = 0, without_state = 0, with_fix = 0;
  std::vector<std::string> phases;
  for (std::size_t i = 0; i < images->size(); ++i) {
    const auto grabbed = source->Grab();
    if (!grabbed) {
      ++unreadable;
      if (!a.quiet) fmt::print("unreadable: {}\n", source->Error());
      continue;
    }
    const std::int64_t stamp_ns = images->stamps_ns[i];
    const auto known = StateAt(states, images->logged_ns[i]);
    if (!known) {
      ++without_state;
      continue;
    }
    const vision::Frame frame{grabbed->image, images->Time_s(i), static_cast<std::int64_t>(i)};
    RequireSizeOf(loaded->parts.camera, frame, a.folder);
    control::VehicleState state = states.states[*known];
    state.t_s = static_cast<double>(states.stamps_ns[*known] - images->stamps_ns.front()) / 1e9;
    const mission::Decision decision = mission->Step(frame, state);
    with_fix += decision.fix.has_value();
    if (phases.empty() || phases.back() != decision.phase) phases.emplace_back(decision.phase);
    csv += Row(frame.sequence, stamp_ns, frame.t_s, records::Recorded(decision, type));
    if (video) video->Write(records::DrawnView(frame, frame.t_s, *mission, records::kRecordingMode));
    records.Write(frame, state, decision, *mission);
  }
  if (video) video->Close();
  if (!a.csv.empty()) WriteFile(a.csv, csv);
  const std::string report = records.Finish("seen again", true, SecondsSince(begun));
  if (a.quiet) return Linger(live.get(), [] { return true; });
  if (!images->note.empty()) fmt::print("{}\n", images->note);
  fmt::print("{}: {} images of {}, {:.1f} s, seen in {:.1f} s, by the states of {}{}\n", plan.name,
             images->size(), images->topic, images->Time_s(images->size() - 1), SecondsSince(begun),
             states.topic,
             states.placed ? "" : ", which have neither position nor velocity: they are taken as 0");
  if (unreadable + without_state > 0)
    fmt::print("left out: {} unreadable, {} from before the first state\n", unreadable, without_state);
  fmt::print("a fix in {} of them; phases: {}\n", with_fix, fmt::join(phases, ", "));
  if (!report.empty()) fmt::print("  {}\n", report);
  Linger(live.get(), [] { return true; });
}

}  // namespace kestrel::app
