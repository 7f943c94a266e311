// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace kestrel::app {

struct ReportArguments {
  std::string folder, second, out;
};

CLI::App* AddReportCommand(CLI::App& app, ReportArguments& arguments);
void ReportCommand(const ReportArguments& arguments);

// Of a flight that has just ended: writes report.html into its folder and returns its name. The flight is what it
// was without: where that cannot be done, standard error has why, and the folder is returned.
std::string ReportOf(const std::filesystem::path& folder);

}  // namespace kestrel::app
