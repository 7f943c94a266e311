// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kestrel::app {

struct ExportArguments {
  std::string folder, to = "mcap", images = "jpeg";
  bool quiet = false;
};

CLI::App* AddExportCommand(CLI::App& app, ExportArguments& arguments);

// Makes a log in the format of others from a flight's folder, into that folder. Throws InputError.
void ExportCommand(const ExportArguments& arguments);

}  // namespace kestrel::app
