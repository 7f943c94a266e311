// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/judgement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/version.h"
#include "flight/load_plugins.h"
#include "records/summary.h"
#include "records/telemetry/flight_mode.h"
#include "sim/machine.h"

namespace kestrel::flight {
namespace {

// What scatter makes of the camera in this run, of the values that have any.
std::map<std::string, double> DrawnValues(const sim::ImageParameters& image, std::uint64_t seed) {
  const sim::ImageParameters drawn = sim::DrawScatter(image, seed);
  const sim::ImageScatter& s = image.scatter;
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

}  // namespace

records::Summary BeginSummary(const Scenario& scenario) {
  records::Summary summary;
  summary.mode = records::kSimulatorMode;
  summary.scenario = scenario.name;
  summary.version = Version();
  summary.plugins = LoadedPlugins();
  summary.seed = scenario.seed;
  summary.machine = sim::ThisMachine();
  summary.drawn = DrawnValues(scenario.image, scenario.seed);
  return summary;
}

void AddSimulator(const sim::Simulator& simulator, records::Summary& summary) {
  summary.renderer = simulator.renderer_name();
  summary.sim_s = simulator.truth().t_s;
  summary.state_hash = simulator.state_hash();
  summary.image_hash = simulator.image_hash();
  summary.stages["physics"] = records::StageTimeOf(simulator.timing().physics_s);
  summary.stages["render"] = records::StageTimeOf(simulator.timing().render_s);
  summary.stages["sensor"] = records::StageTimeOf(simulator.timing().sensor_s);
}

void Judge(const std::map<std::string, Limit>& limits, records::Summary& summary) {
  const auto add = [&](const std::string& name, double limit, bool at_least) {
    const auto found = summary.metrics.find(name);
    const double value =
        found != summary.metrics.end() ? found->second : std::numeric_limits<double>::quiet_NaN();
    summary.criteria.push_back({name, value, limit, at_least, at_least ? value >= limit : value <= limit});
  };
  for (const auto& [name, limit] : limits) {
    if (limit.max) add(name, *limit.max, false);
    if (limit.min) add(name, *limit.min, true);
  }
}

bool AllPassed(const std::vector<records::Criterion>& criteria) {
  return std::all_of(criteria.begin(), criteria.end(), [](const records::Criterion& c) { return c.passed; });
}

}  // namespace kestrel::flight
