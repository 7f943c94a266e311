// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mission/log_row.h"

namespace kestrel::records {

using mission::LogRow;

struct Criterion {
  std::string name;  // a metric: "touchdown_error_m"
  double value = 0;
  double limit = 0;
  bool at_least = false;  // otherwise at most
  bool passed = false;
};

struct StageTime {
  double mean_ms = 0, p99_ms = 0;
};

// summary.json
struct Summary {
  std::string mode;  // records/telemetry/flight_mode.h
  std::string scenario, version, renderer, outcome,
      error;                         // error: why a run broke off, empty when it did not
  std::vector<std::string> plugins;  // files that it was flown with
  std::uint64_t seed = 0;
  bool complete = false, passed = false;
  std::vector<Criterion> criteria;
  std::map<std::string, double> metrics;  // unit in the name
  std::map<std::string, double> drawn;    // what scatter gave this run's camera, by key of the scenario
  double sim_s = 0, wall_s = 0;
  std::map<std::string, StageTime> stages;  // physics, render, sensor, vision, control, record
  std::uint64_t state_hash = 0, image_hash = 0;
  // What of the machine the hashes depend on (sim/machine.h): of flights in the simulator; empty: not known.
  std::map<std::string, std::string> machine;
};

}  // namespace kestrel::records
