// SPDX-License-Identifier: Apache-2.0
#include "app/flight/export_command.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/file/writer_lock.h"
#include "base/user_file.h"
#include "base/version.h"
#include "flight/flight_plan.h"
#include "records/mcap/flight_mcap.h"
#include "records/recording.h"
#include "records/telemetry/telemetry_rows.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

struct Event {
  double t_s = 0;
  std::string what, is;
};

// Of events.log: "    1.250 s  phase: descend". Lines of another form are passed over.
std::vector<Event> ReadEvents(const fs::path& file) {
  std::vector<Event> events;
  std::istringstream lines(ReadFile(file));
  for (std::string line; std::getline(lines, line);) {
    char* end = nullptr;
    const double t_s = std::strtod(line.c_str(), &end);
    const std::string rest = end;
    const std::size_t middle = rest.find(": ");
    if (rest.starts_with(" s  ") && middle != std::string::npos)
      events.push_back({t_s, rest.substr(4, middle - 4), rest.substr(middle + 2)});
  }
  return events;
}

}  // namespace

CLI::App* AddExportCommand(CLI::App& app, ExportArguments& a) {
  CLI::App* command =
      app.add_subcommand("export", "Make a log that other programs open from the folder of a flight");
  command->add_option("folder", a.folder, "Of a flight: what run, serve or fly left")
      ->type_name("DIR")
      ->required();
  command->add_option("--to", a.to, "Format: mcap gives DIR/flight.mcap")
      ->type_name("FORMAT")
      ->capture_default_str();
  command->add_option("--mcap-images", a.images, "Images of DIR/recording in it: jpeg or raw")
      ->type_name("KIND")
      ->capture_default_str();
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n  kestrel run landing --images --out results/runs/first && kestrel export "
      "results/runs/first");
  return command;
}

void ExportCommand(const ExportArguments& a) {
  const fs::path folder = a.folder;
  Mistakes mistakes;
  if (a.to != "mcap") mistakes.Add("--to", "", fmt::format("'{}' is no format", a.to), "valid: mcap");
  if (a.images != "jpeg" && a.images != "raw")
    mistakes.Add("--mcap-images", "", fmt::format("'{}' is no kind of image", a.images), "valid: jpeg, raw");
  for (const char* name : {"scenario.yaml", "telemetry.csv"})
    if (!IsFile(folder / name))
      mistakes.Add("export", "", fmt::format("'{}' holds no {}: not a flight's folder", a.folder, name));
  if (IsFile(folder / "flight.mcap"))
    mistakes.Add(
        "export", "",
        fmt::format("'{}' has a flight.mcap, which may hold more than can be made of the rest", a.folder),
        "valid: a folder without one; move it away");
  mistakes.ThrowIfAny();
  const WriterLock lock = LockFolder(folder);
  const flight::LoadedPlan loaded = flight::LoadPlan((folder / "scenario.yaml").string(), {});
  const records::TelemetryRows telemetry =
      records::ReadTelemetry(folder / "telemetry.csv", loaded.parts.X_BC);

  std::optional<records::Recording> recording;
  if (IsFile(folder / "recording" / "frames.csv")) recording.emplace(folder);
  std::map<std::int64_t, std::size_t> images;  // by sequence
  if (recording)
    for (std::size_t i = 0; i < recording->frames().size(); ++i) images[recording->frames()[i].sequence] = i;

  records::FlightMessageOptions options;
  options.images = a.images == "raw" ? records::McapImages::kRaw : records::McapImages::kJpeg;
  options.truth = telemetry.truth;
  options.camera = loaded.parts.camera;
  options.X_BC = loaded.parts.X_BC;
  if (loaded.plan.flight.type().looks_for_pad) options.outline = loaded.parts.pad.Outline();
  records::FlightMcap mcap(folder / "flight.mcap", options);
  mcap.WriteScenario(ReadFile(folder / "scenario.yaml"), {{"scenario", loaded.plan.name},
                                                          {"mission", loaded.plan.flight.type().name},
                                                          {"seed", std::to_string(loaded.plan.seed)},
                                                          {"version", Version()},
                                                          {"mode", "exported from telemetry.csv"}});
  const std::vector<Event> events = ReadEvents(folder / "events.log");
  auto event = events.begin();
  for (const mission::LogRow& row : telemetry.rows) {
    for (; event != events.end() && event->t_s <= row.now.t_s; ++event)
      mcap.WriteEvent(event->t_s, event->what, event->is);
    const auto image = images.find(row.sequence);
    mcap.Write(row, image == images.end() ? cv::Mat() : recording->At(image->second).image);
  }
  for (; event != events.end(); ++event) mcap.WriteEvent(event->t_s, event->what, event->is);
  mcap.Close();
  if (a.quiet) return;
  fmt::print("{}: {} frames, {} with their images\n", (folder / "flight.mcap").string(),
             telemetry.rows.size(), images.size());
  if (!recording) fmt::print("It has no images, because the flight was not recorded with --images.\n");
}

}  // namespace kestrel::app
