// SPDX-License-Identifier: Apache-2.0
#include "app/flight/identify_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <stdexcept>

#include "base/diagnostics.h"
#include "base/user_file.h"
#include "records/log/identification.h"

namespace kestrel::app {
namespace {

constexpr std::size_t kMaxLogBytes = std::size_t{1} << 31;

// By what it begins with, whatever it is called.
std::vector<records::Identified> IdentifiedIn(std::string_view bytes) {
  if (bytes.starts_with("ULog")) return records::IdentifyUlog(records::ReadUlog(bytes));
  if (bytes.starts_with("\xA3\x95")) return records::IdentifyDataFlash(records::ReadDataFlash(bytes));
  if (bytes.starts_with("sequence,t_s")) return records::IdentifyTelemetry(records::ReadCsvTable(bytes));
  throw std::runtime_error("is none of: ULog of PX4 (.ulg), DataFlash of ArduPilot (.bin), telemetry.csv");
}

}  // namespace

CLI::App* AddIdentifyCommand(CLI::App& app, IdentifyArguments& a) {
  CLI::App* command = app.add_subcommand(
      "identify", "Tell from a flight's log how an aircraft answers its autopilot's commands");
  command
      ->add_option("log", a.log,
                   "ULog of PX4, DataFlash log of ArduPilot (.bin), or a flight's folder or telemetry.csv")
      ->required();
  command->footer(
      "Each parameter is told with one standard deviation, and what the log does not hold enough of with the "
      "reason.\n\n"
      "Examples:\n  kestrel identify results/runs/follow-1\n  kestrel identify 00000042.BIN");
  return command;
}

bool IdentifyCommand(const IdentifyArguments& a) {
  const std::filesystem::path file = std::filesystem::is_directory(a.log) ? a.log / "telemetry.csv" : a.log;
  if (!IsFile(file)) throw InputError(file.string(), NoSuchFile(file));
  const FileContent content = ReadUserFile(file, kMaxLogBytes);
  if (!content.error.empty()) throw InputError(file.string(), content.error);
  std::vector<records::Identified> all;
  try {
    all = IdentifiedIn(content.bytes);
  } catch (const std::runtime_error& e) {
    throw InputError(file.string(), e.what());
  }
  bool any = false;
  for (const records::Identified& each : all) {
    if (!each.missing.empty()) {
      fmt::print("  {:<32} not known: {}\n", each.name, each.missing);
      continue;
    }
    any = true;
    fmt::print("  {:<32} {:8.3f} +- {:.3f} {}\n", each.name, each.value.value, each.value.sd, each.unit);
  }
  return any;
}

}  // namespace kestrel::app
