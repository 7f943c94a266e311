// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "flight/dataset/format/format.h"
#include "flight/dataset/format/sequence.h"
#include "flight/dataset/trajectory/way_file.h"
#include "flight/simulated/scenario.h"

namespace kestrel::flight {

struct DatasetArguments {
  std::string source;  // a scenario, a way (YAML with the key way), or poses
                       // (pose_file.h)
  std::string in;      // of a trajectory: the scenario whose world, camera and pad
                       // are used; empty: none
  std::string format = "euroc";
  std::filesystem::path out;
  std::vector<std::string> overrides;  // of the scenario
  int count = 1;                       // sequences, of the seed and those after it
  std::optional<int> frames;           // of each sequence, at most
  std::optional<double> duration_s;    // the same
  std::optional<double> imu_rate_hz;   // none: the scenario's; 200 of an IMU without errors where it has none
  Extras extras;
  int jobs = 1;
};

// A data set that can be made: all that it is made from.
struct DatasetPlan {
  DatasetArguments arguments;
  std::string scenario;                        // flown, or in whose world the trajectory leads
  std::vector<std::string> overrides;          // of it: those of the arguments and what follows from them
  LoadedScenario first;                        // with its own seed
  std::optional<LoadedTrajectory> trajectory;  // none: the missions are flown
  std::unique_ptr<Format> format;
  std::string settings;  // all that its bytes depend on, in words
};

// Throws InputError with every mistake of the source, the scenario and the folder: one that holds a set of
// other settings too.
DatasetPlan LoadDatasetPlan(const DatasetArguments& arguments);

// The scenario of a sequence, counted from 0: with the seed after that of the one before.
LoadedScenario ScenarioOf(const DatasetPlan& plan, int number);

// Its sequence, without rows.
Sequence BeginSequence(const DatasetPlan& plan, const LoadedScenario& loaded, int number);

}  // namespace kestrel::flight
