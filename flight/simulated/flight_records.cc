// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/flight_records.h"

#include <stdexcept>
#include <utility>

#include "base/file/files.h"
#include "base/printable.h"
#include "base/process/print_note.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "flight/flight_subject.h"
#include "records/telemetry/flight_mode.h"
#include "sim/gltf/scene_glb.h"

namespace kestrel::flight {
namespace {

records::RecorderOptions OptionsFor(const LoadedScenario& loaded, bool video, bool view) {
  records::RecorderOptions options;
  options.video = video;
  if (view) options.video_kbit_s /= 2;
  options.rate_hz = loaded.scenario.image.rate_hz;
  options.plots.title = loaded.scenario.name + ", seed " + std::to_string(loaded.scenario.seed);
  const sim::SceneParameters& scene = loaded.simulator.scene;
  options.plots.mission = options.telemetry.mission = &loaded.scenario.flight.type();
  for (const auto& [metric, limit] : loaded.scenario.criteria) {
    if (limit.max) options.plots.limits.push_back({metric, *limit.max, false});
    if (limit.min) options.plots.limits.push_back({metric, *limit.min, true});
  }
  const bool lies = scene.pad_tilt_deg == 0;  // what hangs on a wall is no frame for a flight
  if (!scene.pad_texture.empty() && lies) options.plots.pad_size_m = scene.pad.size_m;
  return options;
}

// In a folder that the recorder has made.
records::EventLog BeginEvents(const std::filesystem::path& folder, const Scenario& scenario) {
  for (const char* name :
       {"events.log", "flight.mcap", "page.json", "scene.glb", "view.mp4"}) {  // of an earlier run
    std::filesystem::remove(folder / name);
    std::filesystem::remove(PartOf(folder / name));
  }
  WriteFile(folder / "scenario.yaml", ToYaml(scenario));
  return records::EventLog(folder);
}

}  // namespace

records::FlightSubject SubjectOf(const LoadedScenario& loaded, const sim::Simulator& simulator) {
  const Scenario& scenario = loaded.scenario;
  mission::MissionParts parts;
  parts.camera = loaded.simulator.camera;
  parts.X_BC = vision::MountPose(loaded.simulator.mount);
  parts.pad = loaded.pad;
  if (const auto& ground = loaded.simulator.ground)
    parts.ground = vision::GroundSight{nullptr, ground->camera, ground->place, ground->lights};
  records::FlightSubject subject = SubjectOf(scenario, parts, records::kSimulatorMode, loaded.description);
  subject.rate_hz = scenario.image.rate_hz;
  subject.again = loaded.again;
  if (subject.pad) {
    subject.pad->X_NT = simulator.truth().X_NT;
    if (const cv::Mat& picture = loaded.simulator.scene.pad_picture; !picture.empty())
      subject.pad->picture = records::PictureOf(picture);
  }
  return subject;
}

std::string SceneOf(const LoadedScenario& loaded, const sim::Simulator& simulator) {
  try {
    return sim::SceneGlb(simulator.model(), sim::SeenRotors(loaded.simulator.vehicle));
  } catch (const std::runtime_error& e) {  // the flight is what it is without
    PrintNote("no scene.glb: {}\n", Printable(e.what()));
    return {};
  }
}

FlightRecords::FlightRecords(const std::filesystem::path& folder, const LoadedScenario& loaded,
                             const sim::Simulator& simulator, const std::string& scene_glb, bool video,
                             bool view)
    : folder_(folder),
      lock_(LockFolder(folder)),
      recorder_(folder, OptionsFor(loaded, video, view)),
      events_(BeginEvents(folder, loaded.scenario)) {
  // The flight is what it is without them.
  const auto for_page = [&](const char* name, const auto& write) {
    try {
      write();
    } catch (const std::runtime_error& e) {
      PrintNote("no {}: {}\n", name, Printable(e.what()));
      std::error_code none;
      std::filesystem::remove(PartOf(folder / name), none);
    }
  };
  for_page("page.json", [&] { records::WriteSubject(folder, SubjectOf(loaded, simulator)); });
  if (!scene_glb.empty()) for_page("scene.glb", [&] { WriteFile(folder / "scene.glb", scene_glb); });
  if (IsFile(folder / "page.json")) again_ = loaded.again;
  events_.Line(0, "mode", records::kSimulatorMode);
}

void FlightRecords::AddMcap(records::McapImages images, const LoadedScenario& loaded,
                            const mission::MissionParts& parts) {
  records::FlightMessageOptions options = MessageOptionsOf(parts);
  options.images = images;
  mcap_ = std::make_unique<records::FlightMcap>(folder_ / "flight.mcap", std::move(options));
  carried_.emplace(loaded.simulator.instruments, loaded.simulator.cameras);
  const Scenario& scenario = loaded.scenario;
  mcap_->WriteScenario(ToYaml(scenario), {{"scenario", scenario.name},
                                          {"mission", scenario.flight.type().name},
                                          {"seed", std::to_string(scenario.seed)},
                                          {"version", Version()},
                                          {"mode", records::kSimulatorMode}});
  events_.Tell(
      [this](double t_s, std::string_view what, std::string_view is) { mcap_->WriteEvent(t_s, what, is); });
}

void FlightRecords::WriteChanges(const sim::Simulator& simulator) {
  const auto conditions = simulator.camera_changes();
  for (; conditions_written_ < conditions.size(); ++conditions_written_)
    events_.WriteCamera(conditions[conditions_written_].from_s, conditions[conditions_written_].name);
  const auto states = simulator.state_changes();
  for (; states_written_ < states.size(); ++states_written_)
    events_.Line(states[states_written_].t_s, states[states_written_].what, states[states_written_].is);
}

void FlightRecords::Write(const records::LogRow& row, const sim::Simulator& simulator, const cv::Mat& image) {
  recorder_.Write(row);
  if (mcap_) {
    carried_->Write(simulator.readings(), simulator.camera_frames(), row.now.t_s, *mcap_);
    mcap_->Write(row, image);
  }
  WriteChanges(simulator);
  events_.Write(row);
}

void FlightRecords::Write(const MadeChange& change, const Scenario& flown) {
  Note(change.t_s, "change", change.key + ' ' + change.before + " -> " + change.value);
  if (!change.by_hand) return;
  WriteFile(folder_ / "scenario.yaml", ToYaml(flown));
  if (again_.empty()) return;
  again_ = CommandOf((folder_ / "scenario.yaml").string(), {});
  try {
    records::FlightSubject subject = records::ReadSubject(folder_);
    subject.again = again_;
    records::WriteSubject(folder_, subject);
  } catch (const std::runtime_error& e) {  // the flight is what it is without
    PrintNote("page.json has the command of before the change: {}\n", Printable(e.what()));
  }
}

records::Summary FlightRecords::Finish(records::Summary summary, const sim::Simulator& simulator) {
  try {
    WriteChanges(simulator);
    events_.End(summary.sim_s, summary.error.empty() ? summary.outcome : summary.error);
    if (mcap_) mcap_->Close();
  } catch (const std::runtime_error& e) {
    if (summary.error.empty()) summary.error = e.what();
    summary.complete = summary.passed = false;
  }
  try {
    return recorder_.Finish(summary);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(summary.error.empty() ? e.what() : summary.error + "; " + e.what());
  }
}

}  // namespace kestrel::flight
