// SPDX-License-Identifier: Apache-2.0
#include "app/run/run_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>

#include "app/option/colour.h"
#include "app/option/exit_status.h"
#include "app/page/report_command.h"
#include "app/run/run_report.h"
#include "app/run/view_option.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/printable.h"
#include "base/process/end_signals.h"
#include "base/process/print_note.h"
#include "flight/simulated/runner.h"
#include "records/junit.h"
#include "records/mcap/flight_mcap.h"
#include "records/telemetry/flight_mode.h"

namespace kestrel::app {
namespace {

// One line on a terminal, rewritten ten times a second.
class Progress {
 public:
  explicit Progress(double duration_s) : duration_s_(duration_s) {}
  ~Progress() {
    if (shown_) PrintNote("\r\033[K");
  }
  void Show(const records::LogRow& row) {
    const auto now = std::chrono::steady_clock::now();
    if (shown_ && now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    shown_ = true;
    const double wall_s = std::chrono::duration<double>(now - start_).count();
    PrintNote("\r\033[K{:6.1f} of at most {:g} s  {:4.1f} x real time  {:<10} {:<8} height {:5.2f} m",
              row.now.t_s, duration_s_, row.now.t_s / std::max(wall_s, 1e-3), row.decision.phase,
              row.decision.target, row.now.X_NT.p.z() - row.now.X_NB.p.z());
    std::fflush(stderr);
  }

 private:
  double duration_s_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_;
};

}  // namespace

CLI::App* AddRunCommand(CLI::App& app, RunArguments& a) {
  CLI::App* command = app.add_subcommand("run", "Fly a scenario and record it");
  command->add_option("scenario", a.scenario, "A name that `list` shows, or a YAML file")
      ->type_name("SCENARIO")
      ->required();
  command->add_option("--seed", a.seed, "Of everything random, instead of the scenario's");
  command->add_option("--set", a.overrides, "key.path=value, instead of the scenario's; may be repeated")
      ->type_name("KEY=VALUE");
  command->add_option("--out", a.out, "Folder for the records (default results/runs/NAME-SEED)")
      ->type_name("DIR");
  command->add_flag("--no-video", a.no_video, "Do not write video.mp4");
  command->add_flag("--images", a.images,
                    "Write each frame without loss and the autopilot's states to DIR/recording, for replay "
                    "(some 200 kB a frame at 640 x 480)");
  command->add_flag(
      "--mcap{jpeg}", a.mcap,
      "Write DIR/flight.mcap, for Foxglove, PlotJuggler and ROS 2; --mcap=raw has the images without loss");
  command->add_flag("--truth", a.truth,
                    "Write each frame with its true depth, segmentation and optical flow to DIR/truth "
                    "(some 4 MB a frame at 640 x 480)");
  command->add_flag(
      "--events", a.events,
      "Write the events of the scenario's event_camera, and each frame with the last of them, to "
      "DIR/events");
  command
      ->add_option(
          "--view", a.view,
          "Also write the flight from outside to DIR/view.mp4: chase, tower, orbit, top or free, as the "
          "scenario's key view says more closely; with the image on board in a corner: chase+camera")
      ->type_name("VIEW");
  command->add_option("--view-size", a.view_size,
                      "WIDTHxHEIGHT in pixels of that, instead of the scenario's");
  AddLiveOptions(*command, a.live, true);
  command->add_option("--junit", a.junit, "Also write the criteria as JUnit XML to this file")
      ->type_name("FILE");
  command->add_flag("--quiet", a.quiet, "Print nothing but errors, and what failed of a run that did");
  command->footer(
      "Examples:\n  kestrel run landing\n"
      "  kestrel run hover --seed 7 --set wind.mean_m_s=5 --out /tmp/hover\n"
      "  kestrel run follow --live --view chase");
  return command;
}

void PrintNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) fmt::print("  {}\n", Printable(note));
}

int RunCommand(const RunArguments& a) {
  const std::atomic<bool>& interrupted = EndInGoodOrder();
  std::vector<std::string> overrides = a.overrides;
  if (!a.seed.empty()) overrides.push_back("seed=" + a.seed);
  const flight::LoadedScenario loaded = flight::LoadScenario(a.scenario, overrides);
  flight::RunOptions options;
  options.folder =
      a.out.empty() ? fmt::format("results/runs/{}-{}", loaded.scenario.name, loaded.scenario.seed) : a.out;
  options.video = !a.no_video;
  options.images = a.images;
  options.truth = a.truth;
  if (!a.mcap.empty())
    options.mcap = a.mcap == "raw" ? records::McapImages::kRaw : records::McapImages::kJpeg;
  options.events = a.events;
  Mistakes mistakes;
  if (!a.mcap.empty() && a.mcap != "jpeg" && a.mcap != "raw")
    mistakes.Add("--mcap", "", fmt::format("'{}' is no kind of image", a.mcap), "valid: jpeg, raw");
  options.view = ReadView(a.view, a.view_size, loaded.scenario.view, mistakes);
  const std::optional<flight::LiveOptions> of_live = ReadLive(a.live, mistakes);
  CheckWritableFolder(*options.folder, "--out", mistakes);
  CheckWritableFile(a.junit, "--junit", mistakes);
  mistakes.ThrowIfAny();
  const std::unique_ptr<flight::Live> live = MakeLive(of_live);
  options.live = live.get();
  if (!a.quiet) {
    fmt::print("{}  {}, seed {}\n", records::kSimulatorMode, loaded.scenario.name, loaded.scenario.seed);
    PrintNotes(loaded.notes);
  }
  PrintLive(live.get());
  flight::FlightResult result;
  {
    Progress progress(loaded.scenario.duration_s);
    const bool terminal = isatty(STDERR_FILENO) && !a.quiet;
    options.progress = [&](const records::LogRow& row) {
      if (terminal) progress.Show(row);
      return !interrupted.load();
    };
    result = flight::RunFlight(loaded, options);
  }
  const records::Summary& summary = result.summary;
  const std::string report = ReportOf(*options.folder);
  if (!a.junit.empty()) WriteFile(a.junit, records::ToJunit({summary}));
  if (!a.quiet)
    fmt::print("{}", RunReport(summary, report, TakesColours(stdout)));
  else if (!summary.passed)
    PrintNote("{}{}", Verdict(summary, TakesColours(stderr)), MissedCriteria(summary, TakesColours(stderr)));
  Linger(live.get(), [&] { return !interrupted.load(); });
  if (!summary.complete) return kBrokeOff;
  return summary.passed ? kMet : kNotMet;
}

}  // namespace kestrel::app
