// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "flight/dataset/plan.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel dataset`: images, what is truly in them, IMU and truth, in a format that others read.
struct DatasetCommandArguments {
  flight::DatasetArguments set;
  std::string out, world, camera;     // the last two: short for --set
  std::optional<double> rate_hz;      // the same
  std::optional<std::uint64_t> seed;  // the same
};

CLI::App* AddDatasetCommand(CLI::App& app, DatasetCommandArguments& arguments);

// Throws InputError with every mistake.
void DatasetCommand(const DatasetCommandArguments& arguments);

}  // namespace kestrel::app
