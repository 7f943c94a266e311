// SPDX-License-Identifier: Apache-2.0
#include "scenarios/fly_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <ctime>

#include "config/stopwatch.h"
#include "geometry/tait_bryan.h"
#include "scenarios/aircraft.h"
#include "scenarios/files.h"
#include "scenarios/flight_mode.h"
#include "scenarios/fly.h"
#include "scenarios/pre_flight.h"
#include "vision/camera_address.h"

namespace kestrel {
namespace {

std::atomic<bool> interrupted = false;

// What stands in an InputError, as mistakes among others. as: what is to stand in place of a text.
void AddAll(const InputError& error, const std::string& text, const std::string& as, Mistakes& mistakes) {
  for (std::string message : error.messages) {
    if (const std::size_t at = message.find(text); !text.empty() && at != std::string::npos)
      message.replace(at, text.size(), as);
    const std::size_t colon = message.find(": ");
    mistakes.Add(message.substr(0, colon), "", colon == std::string::npos ? "" : message.substr(colon + 2));
  }
}

// The camera of an address, of the size of the calibration and the flight's colour where the address says
// none of them.
CameraAddress CameraAt(const FlyArguments& a, const LoadedPlan& plan, Mistakes& mistakes) {
  std::string address = a.camera;
  const auto add = [&](std::string_view key, const std::string& value) {
    if (address.find(fmt::format("{}=", key)) == std::string::npos)
      address += fmt::format("{}{}={}", address.find('?') == std::string::npos ? "?" : "&", key, value);
  };
  if (!address.starts_with("gst:") && !address.starts_with("file:")) {
    add("width", fmt::format("{}", WidthPx(plan.parts.camera)));
    add("height", fmt::format("{}", HeightPx(plan.parts.camera)));
  }
  if (!address.starts_with("gst:")) add("colour", plan.plan.image.colour ? "true" : "false");
  try {
    return ParseCameraAddress(address);
  } catch (const InputError& e) {
    AddAll(e, address, a.camera, mistakes);
    return {};
  }
}

void PrintCheckList(const std::vector<CheckItem>& items) {
  fmt::print("check list\n");
  for (const CheckItem& item : items)
    fmt::print("  {:<4} {:<26} {}\n", item.ok ? "ok" : "NOT", item.name, item.found);
  std::fflush(stdout);
}

// A line on a terminal, ten times a second; elsewhere one for each change of what matters.
class Progress {
 public:
  explicit Progress(const char* mode) : mode_(mode), terminal_(isatty(STDERR_FILENO)) {}
  ~Progress() {
    if (shown_) fmt::print(stderr, "\r\033[K");
  }
  void Show(const VehicleState& state, const Decision& decision, const SafetyChange& safety) {
    const double now_s = MonotonicNow_s();
    const std::string what =
        fmt::format("{:<10} {:<8} safety: {}", decision.phase, decision.target, NameOf(safety.reaction));
    if (terminal_ ? now_s - last_s_ < 0.1 : what == what_) return;
    fmt::print(stderr, "{}{}  {:6.1f} s  {}  height {:5.2f} m{}", terminal_ ? "\r\033[K" : "", mode_,
               now_s - begun_s_, what, -state.p_NB.z(), terminal_ ? "" : "\n");
    std::fflush(stderr);
    what_ = what;
    last_s_ = now_s;
    shown_ = terminal_;
  }

 private:
  const char* mode_;
  bool terminal_, shown_ = false;
  double begun_s_ = MonotonicNow_s(), last_s_ = 0;
  std::string what_;
};

void Report(const FlyReport& r, bool dry_run, const std::string& folder) {
  const char* mode = dry_run ? kDryRunMode : kRealMode;
  fmt::print("{}  {}{}\n", mode, r.outcome, r.error.empty() ? "" : ": " + r.error);
  if (!r.accomplished)
    fmt::print("  NOT  {}\n", dry_run ? "in order: the check list was not met, or something was lost"
                                      : "accomplished: what the flight is for was not done, or not by its "
                                        "mission alone");
  fmt::print(
      "  {} images flown by, {} overwritten by newer ones; image to setpoint {:.1f} ms, 99 % within "
      "{:.1f} ms\n",
      r.frames, r.images_overwritten, r.mean_ms, r.p99_ms);
  if (r.records_dropped > 0) fmt::print("  {} images could not be recorded in time\n", r.records_dropped);
  fmt::print("  {}\n", folder);
}

}  // namespace

CLI::App* AddFlyCommand(CLI::App& app, FlyArguments& a) {
  CLI::App* command =
      app.add_subcommand("fly", "Fly a mission on a real camera and a real autopilot, after a check list");
  command
      ->add_option("scenario", a.scenario,
                   "A scenario's name or file; what it says of its world is passed over")
      ->required();
  command->add_option("--camera", a.camera, "\n" + CameraAddressForms())->required();
  command
      ->add_option("--autopilot", a.autopilot,
                   "mavlink:udp://HOST:PORT, mavlink:udpin://HOST:PORT, afcs:udp://HOST:PORT, "
                   "asctec:serial:DEVICE")
      ->required();
  command->add_option("--aircraft", a.aircraft, "YAML file: limits, camera's delay, options of the link");
  command->add_option("--set", a.overrides, "key.path=value of the flight, as for run");
  command->add_option("--set-aircraft", a.aircraft_overrides, "key.path=value of the aircraft");
  command->add_flag("--dry-run", a.dry_run, "Compute and show everything and send nothing");
  command->add_flag("--take-control", a.take_control,
                    "Ask the autopilot for the mode in which setpoints are followed (MAVLink)");
  command->add_flag("--arm", a.arm, "Let it start the motors for a take-off (MAVLink)");
  command->add_flag("--pilot-untold", a.pilot_untold,
                    "Fly though the autopilot does not tell of the pilot's switch");
  command->add_option("--for", a.for_s, "How long at most, in s, instead of the scenario's duration_s")
      ->check(CLI::PositiveNumber);
  command->add_option("--out", a.out, "Folder for the records (default results/runs/NAME-flown-TIME)");
  command->add_flag("--no-video", a.no_video, "Do not write video.mp4");
  command->add_flag("--images", a.images, "Write each frame without loss, for replay");
  command->footer(
      "Exit status: 0 the flight did what it is for, 1 it did not or a check failed, 2 bad input.\n"
      "These protocols have no authentication: keep them on a network of your own.\n\nExamples:\n"
      "  kestrel fly landing --camera v4l2:/dev/video0 --autopilot asctec:serial:/dev/ttyUSB0 "
      "--aircraft pelican.yaml --dry-run\n"
      "  kestrel fly landing --camera rtp://127.0.0.1:5600 --autopilot mavlink:udp://127.0.0.1:14580 "
      "--take-control");
  return command;
}

bool FlyCommand(const FlyArguments& a) {
  Mistakes mistakes;
  std::optional<LoadedPlan> loaded;
  try {
    loaded = LoadPlan(a.scenario, a.overrides);
  } catch (const InputError& e) {
    AddAll(e, "", "", mistakes);
  }
  Aircraft aircraft = LoadAircraft(a.aircraft, a.aircraft_overrides, mistakes);
  aircraft.mavlink.take_control |= a.take_control;
  aircraft.mavlink.arm |= a.arm;
  aircraft.pilot_untold |= a.pilot_untold;
  const CameraAddress address = loaded ? CameraAt(a, *loaded, mistakes) : CameraAddress();
  const std::unique_ptr<AutopilotLink> link = MakeLink(a.autopilot, aircraft, mistakes);
  if (!loaded) mistakes.ThrowIfAny();
  const LoadedPlan& plan = *loaded;
  const std::string folder = a.out.empty() ? fmt::format("results/runs/{}-flown-{:%Y%m%d-%H%M%S}",
                                                         plan.plan.name, fmt::localtime(std::time(nullptr)))
                                           : a.out;
  CheckWritableFolder(folder, "--out", mistakes);
  if (a.dry_run && (a.take_control || a.arm))
    mistakes.Add(a.arm ? "--arm" : "--take-control", "",
                 "commands, and --dry-run sends nothing; valid: one of them");
  mistakes.ThrowIfAny();

  const auto stop = [](int signal) {
    interrupted = true;
    std::signal(signal, SIG_DFL);
  };
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  const char* mode = a.dry_run ? kDryRunMode : kRealMode;
  fmt::print("{}  {} by {}, camera {}\n", mode, plan.plan.name, a.autopilot, a.camera);
  std::fflush(stdout);
  LiveCamera camera(SourceAt(address), aircraft.camera);
  PreFlightOptions check;
  check.pilot_untold = aircraft.pilot_untold;
  const std::vector<CheckItem> items = PreFlight(plan, camera, *link, check);
  PrintCheckList(items);
  if (!AllOk(items) && !a.dry_run) {
    fmt::print("{}  not flown: the check list is not met\n", mode);
    return false;
  }

  FlyOptions options;
  options.limits = aircraft.safety;
  options.pilot_untold = aircraft.pilot_untold;
  options.dry_run = a.dry_run;
  options.checked = AllOk(items);
  options.folder = folder;
  options.video = !a.no_video;
  options.images = a.images;
  options.most_s = a.for_s > 0 ? a.for_s : plan.plan.duration_s;
  options.interrupted = &interrupted;
  FlyReport report;
  {
    Progress progress(mode);
    options.progress = [&](const VehicleState& state, const Decision& decision, const SafetyChange& safety) {
      progress.Show(state, decision, safety);
    };
    report = FlyAircraft(plan, camera, *link, options);
  }
  Report(report, a.dry_run, folder);
  return report.accomplished;
}

}  // namespace kestrel
