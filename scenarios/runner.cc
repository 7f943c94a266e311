// SPDX-License-Identifier: Apache-2.0
#include "scenarios/runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "config/stopwatch.h"
#include "scenarios/event_log.h"
#include "scenarios/files.h"
#include "scenarios/flight_loop.h"
#include "scenarios/metrics.h"
#include "scenarios/recorder.h"
#include "scenarios/truth_images.h"
#include "scenarios/version.h"

namespace kestrel {
namespace {

StageTime Statistics(std::vector<double> seconds) {
  if (seconds.empty()) return {};
  double sum = 0;
  for (const double s : seconds) sum += s;
  const std::size_t rank =
      static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(seconds.size()))) - 1;
  std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(rank), seconds.end());
  return {1e3 * sum / static_cast<double>(seconds.size()), 1e3 * seconds[rank]};
}

// What scatter makes of the camera in this run, of the values that have any.
std::map<std::string, double> DrawnValues(const ImageParameters& image, std::uint64_t seed) {
  const ImageParameters drawn = DrawScatter(image, seed);
  const ImageScatter& s = image.scatter;
  std::map<std::string, double> values;
  const auto add = [&](const char* key, double scatter, double value) {
    if (scatter > 0) values[std::string("image.") + key] = value;
  };
  add("noise_grey", s.noise_grey, drawn.noise_grey);
  add("gain", s.gain, drawn.gain);
  add("full_well_e", s.full_well_e, drawn.full_well_e);
  add("gamma", s.gamma, drawn.gamma);
  add("jpeg_quality", s.jpeg_quality, drawn.jpeg_quality);
  add("exposure.time_s", s.time_s, drawn.exposure.time_s);
  add("exposure.line_s", s.line_s, drawn.exposure.line_s);
  add("lens.cos_power", s.cos_power, drawn.lens.cos_power);
  add("lens.vignetting.0", s.vignetting, drawn.lens.vignetting[0]);
  add("lens.defocus_px", s.defocus_px, drawn.lens.defocus_px);
  return values;
}

void Judge(const std::map<std::string, Limit>& limits, Summary& summary) {
  const auto add = [&](const std::string& name, double limit, bool at_least) {
    const auto found = summary.metrics.find(name);
    // What could not be measured did not happen: no touch-down, no fix.
    const double value =
        found != summary.metrics.end() ? found->second : std::numeric_limits<double>::quiet_NaN();
    summary.criteria.push_back({name, value, limit, at_least, at_least ? value >= limit : value <= limit});
  };
  for (const auto& [name, limit] : limits) {
    if (limit.max) add(name, *limit.max, false);
    if (limit.min) add(name, *limit.min, true);
  }
}

}  // namespace

FlightResult RunFlight(const LoadedScenario& loaded, const RunOptions& options) {
  const Scenario& scenario = loaded.scenario;
  FlightResult result;
  Summary& summary = result.summary;
  summary.scenario = scenario.name;
  summary.version = Version();
  summary.seed = scenario.seed;
  summary.drawn = DrawnValues(scenario.image, scenario.seed);

  std::unique_ptr<Mission> mission = MakeMission(loaded);
  SimulatorParameters parameters = loaded.simulator;
  parameters.surfaces = options.folder && options.truth;
  Simulator simulator(parameters);
  summary.renderer = simulator.renderer_name();
  const auto start = std::chrono::steady_clock::now();

  std::optional<Recorder> recorder;
  std::optional<EventLog> events;
  std::optional<TruthImages> truth;
  if (options.folder) {
    RecorderOptions record;
    record.video = options.video;
    record.rate_hz = scenario.image.rate_hz;
    record.plots.title = scenario.name + ", seed " + std::to_string(scenario.seed);
    const SceneParameters& scene = loaded.simulator.scene;
    if (!scene.pad_texture.empty()) record.plots.pad_size_m = scene.pad.size_m;
    recorder.emplace(*options.folder, record);
    std::filesystem::remove(*options.folder / "events.log");  // of an earlier run
    WriteFile(*options.folder / "scenario.yaml", ToYaml(scenario));
    events.emplace(*options.folder);
    if (options.truth) truth.emplace(*options.folder / "truth", simulator.model());
  }

  std::size_t changes_written = 0;
  std::size_t states_written = 0;
  const auto write_changes = [&] {
    const auto changes = simulator.camera_changes();
    for (; changes_written < changes.size(); ++changes_written) events->Write(changes[changes_written]);
    const auto states = simulator.state_changes();
    for (; states_written < states.size(); ++states_written) events->Write(states[states_written]);
  };

  std::vector<double> vision_s, control_s, record_s;
  bool stopped = false;
  try {
    summary.outcome = Fly(
        simulator, simulator, *mission,
        [&](const Frame& frame, const VehicleState& state, const Decision& decision) {
          const auto began = std::chrono::steady_clock::now();
          result.rows.push_back({frame.sequence, simulator.exposure(), simulator.truth(), state, decision});
          const LogRow& row = result.rows.back();
          if (recorder) {
            recorder->Write(row);
            write_changes();
            events->Write(row);
            if (truth) truth->Write(frame.sequence, simulator.picture());
            if (recorder->wants_images()) {
              cv::Mat drawn;
              if (frame.image.channels() == 1) {
                cv::cvtColor(frame.image, drawn, cv::COLOR_GRAY2BGR);
              } else {
                drawn = frame.image.clone();
              }
              mission->Draw(drawn);
              recorder->WriteImage(drawn);
            }
          }
          vision_s.push_back(decision.vision_s);
          control_s.push_back(decision.control_s);
          record_s.push_back(SecondsSince(began));
          stopped = options.progress && !options.progress(row);
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
  summary.sim_s = simulator.truth().t_s;
  summary.wall_s = SecondsSince(start);
  summary.state_hash = simulator.state_hash();
  summary.image_hash = simulator.image_hash();
  summary.metrics = Metrics(result.rows, simulator.touch());
  Judge(scenario.criteria, summary);
  summary.passed = summary.complete && mission->Accomplished() &&
                   std::all_of(summary.criteria.begin(), summary.criteria.end(),
                               [](const Criterion& c) { return c.passed; });
  summary.stages = {{"physics", Statistics(simulator.timing().physics_s)},
                    {"render", Statistics(simulator.timing().render_s)},
                    {"sensor", Statistics(simulator.timing().sensor_s)},
                    {"vision", Statistics(vision_s)},
                    {"control", Statistics(control_s)},
                    {"record", Statistics(record_s)}};
  if (!recorder) return result;
  try {
    write_changes();
    events->End(summary.sim_s, summary.error.empty() ? summary.outcome : summary.error);
  } catch (const std::runtime_error& e) {
    if (summary.error.empty()) summary.error = e.what();
    summary.complete = summary.passed = false;
  }
  try {
    summary = recorder->Finish(summary);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(summary.error.empty() ? e.what() : summary.error + "; " + e.what());
  }
  return result;
}

}  // namespace kestrel
