// SPDX-License-Identifier: Apache-2.0
// The command line: reads what is asked for, has it done, and turns the end into an exit status.
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <opencv2/core/utility.hpp>

#include "app/bench_command.h"
#include "app/camera/calibrate_command.h"
#include "app/camera/mirror_command.h"
#include "app/campaign/campaign_command.h"
#include "app/campaign/tune_command.h"
#include "app/flight/replay_command.h"
#include "app/option/exit_status.h"
#include "app/option/one_of.h"
#include "app/option/parse_command_line.h"
#include "app/simulated/encounters_command.h"
#include "app/simulated/horizon_command.h"
#include "app/simulated/isa_option.h"
#include "app/simulated/render_board.h"
#include "app/simulated/serve_command.h"
#include "app/simulated/view_command.h"
#include "base/file/files.h"
#include "base/printable.h"
#include "base/process/end_signals.h"
#include "base/process/print_note.h"
#include "base/version.h"
#include "flight/simulated/runner.h"
#include "records/junit.h"
#include "records/telemetry/flight_mode.h"

namespace kestrel::app {
namespace {

std::atomic<bool> interrupted = false;

struct RunArguments {
  std::string scenario, out, junit;
  std::vector<std::string> overrides;
  std::string seed;
  bool no_video = false, images = false, truth = false, quiet = false;
};

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
    PrintNote("\r\033[K{:6.1f} of at most {:.0f} s  {:4.1f} x real time  {:<10} {:<8} height {:5.2f} m",
              row.now.t_s, duration_s_, row.now.t_s / std::max(wall_s, 1e-3), row.decision.phase,
              row.decision.target, row.now.X_NT.p.z() - row.now.X_NB.p.z());
    std::fflush(stderr);
  }

 private:
  double duration_s_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_;
};

void Report(const records::Summary& s, const std::string& folder) {
  fmt::print("{}, seed {}: {}\n", s.scenario, s.seed,
             s.error.empty() ? s.outcome : "broke off: " + Printable(s.error));
  for (const records::Criterion& c : s.criteria) {
    // What did not happen has no value: an error at touch-down of a flight that never touched down.
    const std::string value = std::isnan(c.value) ? "not reached" : fmt::format("{:.4g}", c.value);
    fmt::print("  {:<4} {:<26} {:>11}   {} {:g}\n", c.passed ? "ok" : "NOT", c.name, value,
               c.at_least ? "at least" : "at most", c.limit);
  }
  if (s.complete && !s.passed &&
      std::all_of(s.criteria.begin(), s.criteria.end(), [](const records::Criterion& c) { return c.passed; }))
    fmt::print("  NOT  accomplished: the flight ended before what it is for was done\n");
  fmt::print("  {:.1f} s flown in {:.1f} s, {:.1f} x real time, drawn by {}\n", s.sim_s, s.wall_s,
             s.sim_s / std::max(s.wall_s, 1e-9), s.renderer);
  fmt::print("  {}\n", folder);
}

void PrintNotes(const flight::LoadedScenario& loaded) {
  for (const std::string& note : loaded.notes) fmt::print("  {}\n", Printable(note));
}

int Run(const RunArguments& arguments) {
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.seed.empty()) overrides.push_back("seed=" + arguments.seed);
  const flight::LoadedScenario loaded = flight::LoadScenario(arguments.scenario, overrides);
  flight::RunOptions options;
  options.folder = arguments.out.empty()
                       ? fmt::format("results/runs/{}-{}", loaded.scenario.name, loaded.scenario.seed)
                       : arguments.out;
  options.video = !arguments.no_video;
  options.images = arguments.images;
  options.truth = arguments.truth;
  Mistakes mistakes;
  CheckWritableFolder(*options.folder, "--out", mistakes);
  CheckWritableFile(arguments.junit, "--junit", mistakes);
  mistakes.ThrowIfAny();
  if (!arguments.quiet) {
    fmt::print("{}  {}, seed {}\n", records::kSimulatorMode, loaded.scenario.name, loaded.scenario.seed);
    PrintNotes(loaded);
  }
  flight::FlightResult result;
  {
    Progress progress(loaded.scenario.duration_s);
    const bool terminal = isatty(STDERR_FILENO) && !arguments.quiet;
    options.progress = [&](const records::LogRow& row) {
      if (terminal) progress.Show(row);
      return !interrupted.load();
    };
    // The first asks the flight to end in good order; a second one ends the program.
    OnEndSignals([](int) {
      interrupted = true;
      EndOnNextSignal();
    });
    result = flight::RunFlight(loaded, options);
  }
  const records::Summary& summary = result.summary;
  if (!arguments.junit.empty()) WriteFile(arguments.junit, records::ToJunit({summary}));
  if (!arguments.quiet) Report(summary, options.folder->string());
  if (!summary.complete) {
    if (arguments.quiet) PrintNote("kestrel: {}\n", summary.error);
    return kBrokeOff;
  }
  return summary.passed ? kMet : kNotMet;
}

int List() {
  if (ScenarioNames().empty())
    throw InputError({fmt::format("KESTREL_ROOT: '{}' holds no scenarios", Root().string())});
  for (const std::string& name : ScenarioNames()) {
    try {
      const flight::Scenario s = flight::LoadScenario(name).scenario;
      fmt::print("{:<18} mission {:<8} {:>4.0f} s  {}, {}, {}\n", name, s.mission, s.duration_s, s.vehicle,
                 s.camera, s.world);
    } catch (const InputError& e) {
      fmt::print("{:<18} not valid: {}\n", name, e.what());
    }
  }
  return kMet;
}

int Check(const std::string& scenario, const std::vector<std::string>& overrides) {
  const flight::LoadedScenario loaded = flight::LoadScenario(scenario, overrides);
  fmt::print("{} is valid\n", scenario);
  PrintNotes(loaded);
  return kMet;
}

int Main(int argc, char** argv) {
  // The second core draws the next image; threads inside OpenCV would only wait for it.
  cv::setNumThreads(1);
#ifdef __GLIBC__
  // Images come and go with each frame: their memory is kept, not given back and faulted in again.
  mallopt(M_MMAP_THRESHOLD, 1 << 25);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
  CLI::App app{
      "Kestrel: flight by vision, in the loop.\n\nExit status: 0 the run met its criteria, 1 it did not, "
      "2 bad input, 3 the run broke off."};
  app.require_subcommand(1);
  app.set_version_flag("--version", Version());
  RunArguments run;
  CLI::App* run_command = app.add_subcommand("run", "Fly a scenario and record it");
  run_command->add_option("scenario", run.scenario, "A name that `list` shows, or a YAML file")->required();
  run_command->add_option("--seed", run.seed, "Of everything random, instead of the scenario's");
  run_command->add_option("--set", run.overrides,
                          "key.path=value, instead of the scenario's; may be repeated");
  run_command->add_option("--out", run.out, "Folder for the records (default results/runs/NAME-SEED)");
  run_command->add_flag("--no-video", run.no_video, "Do not write video.mp4");
  run_command->add_flag(
      "--images", run.images,
      "Write each frame without loss and the autopilot's states to DIR/recording, for replay "
      "(some 200 kB a frame at 640 x 480)");
  run_command->add_flag("--truth", run.truth,
                        "Write each frame with its true depth, segmentation and optical flow to DIR/truth "
                        "(some 4 MB a frame at 640 x 480)");
  run_command->add_option("--junit", run.junit, "Also write the criteria as JUnit XML to this file");
  run_command->add_flag("--quiet", run.quiet, "Print nothing but errors");
  run_command->footer(
      "Examples:\n  kestrel run landing\n"
      "  kestrel run hover --seed 7 --set wind.mean_m_s=5 --out /tmp/hover");

  CLI::App* list_command = app.add_subcommand("list", "Show the scenarios that there are");

  std::string check_file;
  std::vector<std::string> check_overrides;
  CLI::App* check_command =
      app.add_subcommand("check", "Validate a scenario and its models without flying it");
  check_command->add_option("file", check_file, "A name that `list` shows, or a YAML file")->required();
  check_command->add_option("--set", check_overrides, "key.path=value, as for run");
  check_command->footer("Examples:\n  kestrel check my_flight.yaml --set camera=fisheye");

  flight::ServeArguments serve;
  const CLI::App* serve_command = AddServeCommand(app, serve);
  EncountersArguments encounters;
  const CLI::App* encounters_command = AddEncountersCommand(app, encounters);
  CampaignArguments campaign;
  const CLI::App* campaign_command = AddCampaignCommand(app, campaign);
  TuneArguments tune;
  const CLI::App* tune_command = AddTuneCommand(app, tune);

  BenchArguments bench;
  CLI::App* bench_command = app.add_subcommand("bench", "Measure: a table of figures beside their targets");
  // Of campaigns by its name alone: it flies for minutes, and kills itself.
  const std::vector<std::string> bench_names = BenchNames();
  bench_command
      ->add_option("name", bench.name,
                   fmt::format("{}; all but campaign, wire and link_faults when none is given",
                               fmt::join(bench_names, ", ")))
      ->check(OneOf(bench_names));
  bench_command->add_option("--seeds", bench.seeds, "A..B, first and last")->capture_default_str();
  bench_command->add_option("--jobs", bench.jobs, "Flights at the same time")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  bench_command->add_option("--json", bench.json, "Also write the figures as JSON to this file");
  bench_command
      ->add_option("--out", bench.out,
                   "Folder for the rows and pictures of horizon, and for the pictures of contrast's failures")
      ->capture_default_str();
  bench_command->footer("Examples:\n  kestrel bench flights --seeds 1..20\n  kestrel bench render");

  ReplayArguments replay;
  const CLI::App* replay_command = AddReplayCommand(app, replay);
  MirrorArguments mirror;
  CLI::App* mirror_command = AddMirrorCommand(app, mirror);
  ViewArguments view;
  const CLI::App* view_command = AddViewCommand(app, view);
  HorizonArguments horizon;
  const CLI::App* horizon_command = AddHorizonCommand(app, horizon);
  CalibrateArguments calibrate;
  const CLI::App* calibrate_command = AddCalibrateCommand(app, calibrate);
  RenderBoardArguments render_board;
  const CLI::App* render_board_command = AddRenderBoardCommand(app, render_board);

  // Of all that fly.
  std::string isa;
  for (const char* name : {"run", "serve", "encounters", "campaign", "tune", "bench", "replay"})
    AddIsaOption(app.get_subcommand(name), isa);
  // Last, or each verb without a footer of its own would have this one.
  app.footer(
      "Examples:\n  kestrel run landing\n  kestrel check my_flight.yaml\n"
      "  kestrel bench flights --seeds 1..20\n"
      "  kestrel calibrate photos/*.jpg --model pinhole --out calibration");

  if (const auto status = ParseCommandLine(app, argc, argv)) return *status;
  try {
    GoBy(isa, argv);
    if (*run_command) return Run(run);
    if (*serve_command) return ServeCommand(serve);
    if (*list_command) return List();
    if (*check_command) return Check(check_file, check_overrides);
    if (*mirror_command) {
      MirrorCommand(mirror);
      return kMet;
    }
    if (*view_command) {
      ViewCommand(view);
      return kMet;
    }
    if (*horizon_command) {
      HorizonCommand(horizon);
      return kMet;
    }
    if (*calibrate_command) {
      CalibrateCommand(calibrate);
      return kMet;
    }
    if (*render_board_command) {
      RenderBoardCommand(render_board);
      return kMet;
    }
    if (*replay_command) return ReplayCommand(replay) ? kMet : kNotMet;
    if (*encounters_command) return EncountersCommand(encounters) ? kMet : kNotMet;
    if (*campaign_command) return CampaignCommand(campaign) ? kMet : kNotMet;
    if (*tune_command) return TuneCommand(tune) ? kMet : kNotMet;
    if (*bench_command) {
      Mistakes mistakes;
      CheckWritableFile(bench.json, "--json", mistakes);
      if (bench.name.empty() || bench.name == "horizon") CheckWritableFolder(bench.out, "--out", mistakes);
      mistakes.ThrowIfAny();
      return Bench(bench) ? kMet : kNotMet;
    }
  } catch (const InputError& e) {
    PrintNote("{}\n", e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    PrintNote("kestrel: {}\n", Printable(e.what()));
    return kBrokeOff;
  }
  return kBadInput;
}

}  // namespace
}  // namespace kestrel::app

int main(int argc, char** argv) { return kestrel::app::ExitWith(kestrel::app::Main(argc, argv)); }
