// SPDX-License-Identifier: Apache-2.0
#include "app/run/demo_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "app/option/exit_status.h"
#include "app/page/report_command.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/end_signals.h"
#include "flight/simulated/runner.h"

namespace kestrel::app {
namespace {

struct Act {
  const char *scenario, *sentence;
  double most_s;  // of the flight
};

constexpr std::array<Act, 4> kActs{{
    {"landing",
     "It finds the helipad in the image of its camera, descends over it and lands on it: the pose of the pad "
     "in "
     "each image is all that it knows of where it is.",
     40},
    {"follow",
     "It follows a balloon that is carried about in the wind: where the balloon is in the image says where "
     "to fly.",
     25},
    {"avoid",
     "Two intruders cross its way: it sees with a fisheye whether they are on a collision course, and passes "
     "them.",
     40},
    {"attitude_1",
     "It reads its attitude from the skyline of hills far away, while the autopilot holds it high above the "
     "ground.",
     25},
}};
constexpr double kBetween_s = 4;  // to read what came of it

void Rest(double duration_s, const std::function<bool()>& go_on) {
  using namespace std::chrono_literals;
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(duration_s);
  while (go_on() && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(50ms);
}

}  // namespace

CLI::App* AddDemoCommand(CLI::App& app, DemoArguments& a) {
  CLI::App* command = app.add_subcommand(
      "demo", "Fly a landing, a balloon, two intruders and a skyline in the browser, in under three minutes");
  AddLiveOptions(*command, a.live, true);
  command->add_option("--out", a.out, "Folder for the records of all flights (default results/runs/demo)")
      ->type_name("DIR");
  command->footer("Examples:\n  kestrel demo\n  kestrel demo --live 9000 --live-address 0.0.0.0");
  return command;
}

int DemoCommand(const DemoArguments& a) {
  Mistakes mistakes;
  LiveArguments of_live = a.live;
  if (!of_live.port) of_live.port = "";
  std::optional<flight::LiveOptions> options = ReadLive(of_live, mistakes);
  const std::filesystem::path out = a.out.empty() ? "results/runs/demo" : a.out;
  CheckWritableFolder(out.string(), "--out", mistakes);
  mistakes.ThrowIfAny();
  options->await_viewer = true;
  std::vector<flight::LoadedScenario> scenarios;
  for (const Act& act : kActs) {
    scenarios.push_back(flight::LoadScenario(act.scenario, {fmt::format("duration_s={:g}", act.most_s)}));
    scenarios.back().description = act.sentence;
  }

  const std::unique_ptr<flight::Live> live = MakeLive(options);
  PrintLive(live.get());
  fmt::print("Open this address in a browser: the flights begin then. Ctrl-C ends them.\n");
  std::fflush(stdout);
  const std::atomic<bool>& interrupted = EndInGoodOrder();
  const auto go_on = [&] { return !interrupted.load(); };
  flight::RunOptions run;
  run.live = live.get();
  int status = kMet;
  std::size_t act = 0;
  bool told = false;
  run.progress = [&](const records::LogRow& row) {
    // Of the first frame it is asked until there is a viewer.
    if (row.sequence > 0 && !std::exchange(told, true)) {
      fmt::print("{} of {}  {}: {}\n", act + 1, scenarios.size(), kActs[act].scenario, kActs[act].sentence);
      std::fflush(stdout);
    }
    return go_on();
  };
  for (; act < scenarios.size() && go_on(); ++act) {
    if (act > 0) Rest(kBetween_s, go_on);
    told = false;
    run.folder = out / kActs[act].scenario;
    const records::Summary summary = flight::RunFlight(scenarios[act], run).summary;
    if (!summary.complete) status = kBrokeOff;
    if (!go_on()) break;
    fmt::print("  {}: {}\n", summary.outcome, ReportOf(*run.folder));
    std::fflush(stdout);
  }
  Linger(live.get(), go_on);
  return status;
}

}  // namespace kestrel::app
