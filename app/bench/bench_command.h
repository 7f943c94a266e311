// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel bench`: figures beside their targets.
struct BenchArguments {
  std::string name;      // empty: all
  std::string pictures;  // folder of horizon_pictures
  double fov_deg = 60;   // of those
  std::string seeds = "1..20";
  int jobs = 2;
  std::string json;
  std::string out = "results/runs/bench";  // has a folder for the files of each bench that leaves some
  std::string backend = "osmesa";          // of OpenGL
  // Of timings alone.
  std::string against;
  int rounds = 16;
  std::string clock = "processor";
  bool in_turn = false;
};

CLI::App* AddBenchCommand(CLI::App& app, BenchArguments& arguments);

// Measures, prints a table of figures beside their targets, and returns whether all of them were met. Throws
// InputError if the seeds are not A..B or a file cannot be written.
bool BenchCommand(const BenchArguments& arguments);

}  // namespace kestrel::app
