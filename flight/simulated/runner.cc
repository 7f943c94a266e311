// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/runner.h"

#include <chrono>

#include "base/stopwatch.h"
#include "flight/simulated/begin_live.h"
#include "flight/simulated/flight_records.h"
#include "flight/simulated/images/event_files.h"
#include "flight/simulated/images/truth_images.h"
#include "flight/simulated/judgement.h"
#include "flight/simulated/view/view_video.h"
#include "mission/flight_loop.h"
#include "records/recording.h"
#include "records/summary.h"
#include "records/telemetry/flight_mode.h"
#include "records/telemetry/metrics.h"
#include "records/video/drawn_view.h"
#include "vision/write_image.h"

namespace kestrel::flight {

FlightResult RunFlight(const LoadedScenario& loaded, const RunOptions& options) {
  const Scenario& scenario = loaded.scenario;
  FlightResult result;
  records::Summary& summary = result.summary;
  summary = BeginSummary(scenario);

  sim::SimulatorParameters parameters = loaded.simulator;
  parameters.surfaces = options.folder && options.truth;
  if (options.folder && options.events) parameters.events = scenario.event_camera;
  sim::Simulator simulator(parameters);
  mission::MissionParts parts = PartsOf(loaded, simulator.model());
  if (parts.ground) parts.ground->stream = simulator.ground_camera();
  const std::unique_ptr<mission::Mission> mission = scenario.flight->Make(parts);
  const auto start = std::chrono::steady_clock::now();

  const std::string scene = options.folder || options.live ? SceneOf(loaded, simulator) : "";
  std::optional<FlightRecords> records;
  std::optional<TruthImages> truth;
  std::optional<EventFiles> events;
  std::optional<ViewVideo> view;
  std::optional<records::RecordingWriter> recording;
  if (options.folder) {
    records.emplace(*options.folder, loaded, simulator, scene, options.video, options.view.has_value());
    if (options.mcap) records->AddMcap(*options.mcap, loaded, parts);
    if (options.images) {
      recording.emplace(*options.folder, scenario.flight.type());
      records::WriteOwnParts(*options.folder, parts.own_parts);
    }
    if (options.truth) truth.emplace(*options.folder / "truth", simulator.model());
    if (options.events) events.emplace(*options.folder / "events");
  }

  if (options.view) {
    ViewOptions of_view = *options.view;
    if (options.live)
      of_view.on_frame = [live = options.live, told = of_view.on_frame](double t_s, const cv::Mat& bgr) {
        if (live->WantsPicture(Picture::kView)) live->Show(Picture::kView, t_s, bgr.clone());
        if (told) told(t_s, bgr);
      };
    view.emplace(simulator, of_view,
                 options.folder ? std::optional(*options.folder / "view.mp4") : std::nullopt,
                 scenario.image.rate_hz, scenario.render.threads);
  }

  Changes in_flight(loaded, simulator, mission.get(), [&](const MadeChange& change) {
    if (records) records->Write(change, in_flight.flown());
  });
  if (options.live) {
    BeginLive(*options.live, loaded, simulator, scene, parts, in_flight, records ? &*records : nullptr);
    if (records)
      records->Tell([live = options.live](double t_s, std::string_view what, std::string_view is) {
        live->Event(t_s, what, is);
      });
  }
  std::vector<double> vision_s, control_s, record_s;
  bool stopped = false;
  try {
    summary.outcome = mission::Fly(
        simulator, simulator, *mission,
        [&](const vision::Frame& frame, const control::VehicleState& state,
            const mission::Decision& decision) {
          mission::RequireNumbers(frame, state, decision);
          const auto began = std::chrono::steady_clock::now();
          result.rows.push_back({frame.sequence, simulator.exposure(), simulator.truth(), state, decision});
          const records::LogRow& row = result.rows.back();
          cv::Mat drawn_once;
          const auto drawn = [&] {
            if (drawn_once.empty())
              drawn_once = records::DrawnView(frame, row.now.t_s, *mission, records::kSimulatorMode);
            return drawn_once;
          };
          if (records) {
            records->Write(row, simulator, frame.image);
            if (truth) truth->Write(frame.sequence, simulator.picture());
            if (events) {
              events->Write(simulator.event_camera()->Take());
              events->WriteView(frame.sequence, frame.t_s, frame.image);
            }
            if (recording) recording->Write(frame, state, decision);
            if (records->recorder().wants_images()) {
              records->recorder().WriteImage(drawn());
              records->recorder().WriteProduct(mission->ProductImage());
            }
          }
          if (view) view->Write(simulator, frame.image);
          if (options.live) {
            options.live->Row(row, options.live->WantsImage() ? frame.image : cv::Mat());
            if (options.live->WantsPicture(Picture::kOnBoard))
              options.live->Show(Picture::kOnBoard, row.now.t_s, drawn());
          }
          if (options.watch) options.watch(simulator, frame);
          vision_s.push_back(decision.vision_s);
          control_s.push_back(decision.control_s);
          record_s.push_back(SecondsSince(began));
          stopped = options.progress && !options.progress(row);
          in_flight.MakeDue();
          if (options.change) options.change(in_flight);
          const auto go_on = [&] { return !options.progress || options.progress(row); };
          if (options.live && !stopped) stopped = !options.live->Wait(row.now.t_s, go_on);
          return !stopped;
        });
    if (summary.outcome.empty()) {
      const auto changes = simulator.camera_changes();
      const bool blind = !changes.empty() && changes.back().off;
      summary.outcome = stopped ? "interrupted" : blind ? "camera off" : "completed";
    }
    if (stopped) summary.error = "interrupted";
  } catch (const std::exception& e) {
    summary.outcome = "broke off";
    summary.error = e.what();
  }

  summary.complete = summary.error.empty();
  summary.wall_s = SecondsSince(start);
  AddSimulator(simulator, summary);
  summary.metrics = records::Metrics(result.rows, simulator.touch(), &scenario.flight.type());
  Judge(scenario.criteria, summary);
  summary.passed = summary.complete && mission->Accomplished() && AllPassed(summary.criteria);
  summary.stages["vision"] = records::StageTimeOf(vision_s);
  summary.stages["control"] = records::StageTimeOf(control_s);
  summary.stages["record"] = records::StageTimeOf(record_s);
  try {
    if (view) view->Close();
    if (recording) recording->Close();
    if (events) {
      simulator.event_camera()->Finish();
      events->Write(simulator.event_camera()->Take());
      events->Close();
    }
    if (records) mission->WriteProducts(*options.folder);
  } catch (const std::exception& e) {
    if (summary.error.empty()) summary.error = e.what();
    summary.complete = summary.passed = false;
  }
  if (records) summary = records->Finish(summary, simulator);
  if (options.live) options.live->End(summary);
  return result;
}

}  // namespace kestrel::flight
