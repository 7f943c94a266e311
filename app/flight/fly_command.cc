// SPDX-License-Identifier: Apache-2.0
#include "app/flight/fly_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <optional>
#include <utility>
#include <vector>

#include "app/page/report_command.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/file/writer_lock.h"
#include "base/printable.h"
#include "base/process/end_signals.h"
#include "base/stopwatch.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "flight/hardware/aircraft.h"
#include "flight/hardware/fly.h"
#include "flight/hardware/live_ground_camera.h"
#include "flight/hardware/pre_flight.h"
#include "geometry/tait_bryan.h"
#include "records/telemetry/flight_mode.h"
#include "vision/capture/camera_address.h"

namespace kestrel::app {
namespace {

// What a camera is to give where its address says nothing of it.
struct Wanted {
  int width_px = 640, height_px = 480;
  bool colour = false;
  double rate_hz = 20;  // of files
};

Wanted WantedOf(const vision::CameraModel& camera, bool colour, double rate_hz) {
  return {vision::WidthPx(camera), vision::HeightPx(camera), colour, rate_hz};
}

// The camera of an address, with what is wanted where the address does not say it.
vision::CameraAddress CameraAt(const std::string& given, const Wanted& wanted, Mistakes& mistakes) {
  std::string address = given;
  const auto add = [&](std::string_view key, const std::string& value) {
    if (address.find(fmt::format("{}=", key)) == std::string::npos)
      address += fmt::format("{}{}={}", address.find('?') == std::string::npos ? "?" : "&", key, value);
  };
  if (!address.starts_with("gst:") && !address.starts_with("file:")) {
    add("width", fmt::format("{}", wanted.width_px));
    add("height", fmt::format("{}", wanted.height_px));
  }
  if (!address.starts_with("gst:")) add("colour", wanted.colour ? "true" : "false");
  try {
    vision::CameraAddress camera = vision::ParseCameraAddress(address);
    auto* folder = std::get_if<vision::FolderSourceOptions>(&camera);
    auto* video = std::get_if<vision::OpenCvSourceOptions>(&camera);
    const bool paced = folder && (folder->as_recorded || folder->rate_hz > 0);
    if (folder && !paced) folder->rate_hz = wanted.rate_hz;
    if (video && video->kind == vision::OpenCvSourceOptions::Kind::kFile && video->rate_hz == 0)
      video->rate_hz = wanted.rate_hz;
    return camera;
  } catch (const InputError& e) {
    for (Diagnostic each : e.diagnostics) {
      if (each.place() == vision::PlaceOfCamera(address)) each.file = vision::PlaceOfCamera(given).file;
      mistakes.Add(std::move(each));
    }
    return {};
  }
}

// Of a mission by a camera on the ground whose aircraft carries none: the first camera is that one, and paces the
// flight.
bool PacedByGround(const FlyArguments& a, const flight::LoadedPlan& plan) {
  return plan.parts.ground && !plan.plan.flight.type().looks_for_pad && a.cameras.size() == 1;
}

// Whether there are as many cameras as the mission flies by.
void CheckCameras(const FlyArguments& a, const flight::LoadedPlan& plan, Mistakes& mistakes) {
  const mission::MissionType& type = plan.plan.flight.type();
  if (a.cameras.size() > (type.needs_ground_camera ? 2 : 1))
    mistakes.Add("--camera", "",
                 fmt::format("{} of them, and the mission '{}' flies by {}", a.cameras.size(), type.name,
                             type.needs_ground_camera ? "two at most" : "one"),
                 type.needs_ground_camera ? "valid: that on board, then that on the ground" : "valid: one");
  if (type.needs_ground_camera && type.looks_for_pad && a.cameras.size() == 1)
    mistakes.Add("--camera", "", fmt::format("one, and the mission '{}' flies by two", type.name),
                 "valid: --camera twice, that on board, then that on the ground");
}

void ClearLine() { std::fputs("\r\033[K", stderr); }

// What a camera or an autopilot says may be a part of it. A terminal that has gone is no reason to break off
// a flight, and so no exception.
void Print(std::FILE* file, const std::string& text) {
  std::fputs(Printable(text).c_str(), file);
  std::fflush(file);
}

std::string Text(const flight::CheckItem& item) {
  return fmt::format("{:<4} {:<26} {}", item.ok ? "ok" : "NOT", item.name, item.found);
}

// What a flight is flown with beside the scenario and the aircraft, as events.log has it.
std::vector<std::pair<std::string, std::string>> FlownWith(const FlyArguments& a, double max_s) {
  std::string options = fmt::format("--for {:g}", max_s);
  for (const auto& [given, name] : {std::pair{a.dry_run, "--dry-run"},
                                    {a.take_control, "--take-control"},
                                    {a.arm, "--arm"},
                                    {a.pilot_untold, "--pilot-untold"}})
    if (given) options += fmt::format(" {}", name);
  return {{"version", Version()},
          {"scenario", a.scenario},
          {"camera", fmt::format("{}", fmt::join(a.cameras, ", "))},
          {"autopilot", a.autopilot},
          {"options", options}};
}

void CheckTimes(const FlyArguments& a, Mistakes& mistakes) {
  constexpr double kLeast_s = 0.1, kMost_s = 36000;  // as duration_s
  if (a.for_s && !(*a.for_s >= kLeast_s && *a.for_s <= kMost_s))
    mistakes.Add("--for", "", fmt::format("{:g} is no time in s that a flight may last", *a.for_s),
                 fmt::format("valid: from {:g} to {:g}", kLeast_s, kMost_s));
  if (a.wait_s && !(*a.wait_s >= 0 && *a.wait_s <= kMost_s))
    mistakes.Add("--wait", "", fmt::format("{:g} is no time in s to wait", *a.wait_s),
                 fmt::format("valid: from 0 to {:g}", kMost_s));
}

// What is waited for before a flight: a line on a terminal, ten times a second; elsewhere one for each change of it,
// and after that every ten seconds. What comes at once is not waited for.
class Waiting {
 public:
  explicit Waiting(double most_s) : most_s_(most_s), terminal_(isatty(STDERR_FILENO)) {}
  ~Waiting() {
    if (shown_) ClearLine();
  }
  void Show(const std::string& what, double waited_s) {
    constexpr double kAtOnce_s = 1, kOften_s = 0.1, kSeldom_s = 10;
    const double now_s = MonotonicNow_s();
    const bool changed = what != what_;
    if (waited_s < kAtOnce_s || now_s - last_s_ < kOften_s) return;
    if (!terminal_ && !changed && now_s - last_s_ < kSeldom_s) return;
    if (shown_) ClearLine();
    Print(stderr,
          fmt::format("waits for {} ({:.0f} of {:g} s){}", what, waited_s, most_s_, terminal_ ? "" : "\n"));
    shown_ = terminal_;
    what_ = what;
    last_s_ = now_s;
  }

 private:
  double most_s_;
  bool terminal_, shown_ = false;
  double last_s_ = 0;
  std::string what_;
};

// A line on a terminal, ten times a second; elsewhere one for each change of what matters.
class Progress {
 public:
  explicit Progress(std::string mode) : mode_(std::move(mode)), terminal_(isatty(STDERR_FILENO)) {}
  ~Progress() {
    if (shown_) ClearLine();
  }
  void Show(const control::VehicleState& state, const mission::Decision& decision,
            const control::SafetyChange& safety) {
    const double now_s = MonotonicNow_s();
    const std::string what = fmt::format("{:<10} {:<8} safety: {}", decision.phase, decision.target,
                                         control::NameOf(safety.reaction));
    if (terminal_ ? now_s - last_s_ < 0.1 : what == what_) return;
    if (terminal_) ClearLine();
    Print(stderr, fmt::format("{}  {:6.1f} s  {}  height {:5.2f} m{}", mode_, now_s - begun_s_, what,
                              -state.p_NB.z(), terminal_ ? "" : "\n"));
    what_ = what;
    last_s_ = now_s;
    shown_ = terminal_;
  }
  // A line that stays.
  void Tell(const std::string& text) {
    if (shown_) ClearLine();
    shown_ = false;
    Print(stderr, fmt::format("{}  {:6.1f} s  {}\n", mode_, MonotonicNow_s() - begun_s_, text));
  }

 private:
  std::string mode_;
  bool terminal_, shown_ = false;
  double begun_s_ = MonotonicNow_s(), last_s_ = 0;
  std::string what_;
};

void Report(const flight::FlyReport& r, const FlyArguments& a, const std::string& mode,
            const std::string& page) {
  std::string text = fmt::format("{}  {}{}\n", mode, r.outcome, r.error.empty() ? "" : ": " + r.error);
  if (!r.lag.empty()) text += fmt::format("  {}: lower them, or ask the autopilot for less shaping\n", r.lag);
  if (!r.release.empty()) text += fmt::format("  at the end: {}\n", r.release);
  if (!r.accomplished)
    text += fmt::format(
        "  NOT  {}\n", a.dry_run ? "in order: the check list was not met, or something was lost"
                                 : "accomplished: what the flight is for was not done, or not by its mission "
                                   "alone");
  text += fmt::format(
      "  {} images flown by, {} overwritten by newer ones; image to setpoint {:.1f} ms, 99 % within "
      "{:.1f} ms\n",
      r.frames, r.images_overwritten, r.mean_ms, r.p99_ms);
  if (r.records_dropped > 0)
    text += fmt::format("  {} images could not be recorded in time\n", r.records_dropped);
  Print(stdout, text + fmt::format("  {}\n", page));
}

// Of a flight that ends before it begins: its folder says why.
void ReportNotFlown(const flight::LoadedPlan& plan, const flight::FlyOptions& options,
                    const std::string& why) {
  std::string text = fmt::format("{}  not flown: {}\n", records::LiveMode(false, options.dry_run), why);
  try {
    flight::RecordNotFlown(plan, options, why);
    text += fmt::format("  {}\n", options.folder->string());
  } catch (const std::exception& e) {
    text += fmt::format("  without record: {}\n", e.what());
  }
  Print(stdout, text);
}

}  // namespace

CLI::App* AddFlyCommand(CLI::App& app, FlyArguments& a) {
  CLI::App* command =
      app.add_subcommand("fly", "Fly a mission on a real camera and a real autopilot, after a check list");
  command
      ->add_option("scenario", a.scenario,
                   "A scenario's name or file; what it says of its world is passed over")
      ->type_name("SCENARIO")
      ->required();
  command
      ->add_option(
          "--camera", a.cameras,
          "Twice for a mission with a camera on the ground: that on board, then that on the ground\n" +
              vision::CameraAddressForms())
      ->required()
      ->allow_extra_args(false);
  command
      ->add_option("--autopilot", a.autopilot,
                   "mavlink:udp://HOST:PORT, mavlink:udpin://HOST:PORT, mavlink:tcp://HOST:PORT, "
                   "afcs:udp://HOST:PORT, asctec:serial:DEVICE")
      ->required();
  command->add_option("--aircraft", a.aircraft, "YAML file: limits, camera's delay, options of the link")
      ->type_name("FILE");
  command->add_option("--set", a.overrides, "key.path=value of the flight, as for run")
      ->type_name("KEY=VALUE");
  command->add_option("--set-aircraft", a.aircraft_overrides, "key.path=value of the aircraft")
      ->type_name("KEY=VALUE");
  command->add_flag("--dry-run", a.dry_run,
                    "Compute and show everything and send no setpoint; what opens the link and asks "
                    "for the state is sent");
  command->add_flag("--take-control", a.take_control,
                    "Ask the autopilot for the mode in which setpoints are followed (MAVLink)");
  command->add_flag("--arm", a.arm, "Let it start the motors for a take-off (MAVLink)");
  command->add_flag("--pilot-untold", a.pilot_untold,
                    "Fly though the autopilot does not tell of the pilot's switch");
  command->add_option("--for", a.for_s, "How long at most, in s, instead of the scenario's duration_s");
  command->add_option(
      "--wait", a.wait_s,
      fmt::format(
          "How long, in s, the camera's first image is waited for, and then the autopilot's state: its "
          "estimator may take 40 s (default {:g})",
          flight::kWait_s));
  AddLiveOptions(*command, a.live, false);
  command->add_option("--out", a.out, "Folder for the records (default results/runs/NAME-flown-TIME)")
      ->type_name("DIR");
  command->add_flag("--no-video", a.no_video, "Do not write video.mp4");
  command->add_flag("--images", a.images, "Write each frame without loss, for replay");
  command->footer(
      "Exit status: 0 the flight did what it is for under its mission's own control, 1 it did not, or a "
      "check "
      "failed, 2 bad input. Of a dry run 0: the check list was met, and neither images nor the state were "
      "lost.\n"
      "These protocols have no authentication: keep them on a network of your own.\n\nExamples:\n"
      "  kestrel fly landing --camera v4l2:/dev/video0 --autopilot asctec:serial:/dev/ttyUSB0 "
      "--aircraft pelican.yaml --dry-run\n"
      "  kestrel fly landing --camera rtp://127.0.0.1:5600 --autopilot mavlink:udp://127.0.0.1:14580 "
      "--take-control\n"
      "  kestrel fly hover --camera rtp://127.0.0.1:5600 --autopilot mavlink:tcp://127.0.0.1:5760 "
      "--take-control");
  return command;
}

bool FlyCommand(const FlyArguments& a) {
  Mistakes mistakes;
  std::optional<flight::LoadedPlan> loaded;
  try {
    loaded = flight::LoadPlan(a.scenario, a.overrides);
  } catch (const InputError& e) {
    mistakes.Add(e);
  }
  if (loaded)
    flight::CheckDeclared(*loaded->plan.flight->Make(loaded->parts), loaded->plan.mission, mistakes);
  flight::Aircraft aircraft = flight::LoadAircraft(a.aircraft, a.aircraft_overrides, mistakes);
  if (a.dry_run) aircraft.mavlink.stand_by = false;  // which sends setpoints
  aircraft.mavlink.take_control |= a.take_control;
  aircraft.mavlink.arm |= a.arm;
  aircraft.pilot_untold |= a.pilot_untold;
  const bool by_ground = loaded && PacedByGround(a, *loaded);
  if (by_ground) {
    loaded->parts.camera = loaded->parts.ground->camera;
    loaded->plan.camera = loaded->plan.ground_camera->camera;
    loaded->plan.image.colour = true;
  }
  if (loaded) CheckCameras(a, *loaded, mistakes);
  Wanted wanted, of_ground{.colour = true};
  if (loaded) {
    wanted = WantedOf(loaded->parts.camera, loaded->plan.image.colour, loaded->plan.image.rate_hz);
    if (loaded->parts.ground)
      of_ground = WantedOf(loaded->parts.ground->camera, true, loaded->plan.image.rate_hz);
  }
  const vision::CameraAddress address = CameraAt(a.cameras.front(), wanted, mistakes);
  std::optional<vision::CameraAddress> ground_address;
  if (a.cameras.size() > 1) ground_address = CameraAt(a.cameras[1], of_ground, mistakes);
  const std::unique_ptr<control::AutopilotLink> link = flight::MakeLink(a.autopilot, aircraft, mistakes);
  CheckTimes(a, mistakes);
  if (a.dry_run && (a.take_control || a.arm))
    mistakes.Add(a.arm ? "--arm" : "--take-control", "", "commands the aircraft, which --dry-run does not",
                 "valid: one of them");
  flight::FlyOptions options;
  options.folder =
      !a.out.empty() ? a.out
                     : fmt::format("results/runs/{}-flown-{:%Y%m%d-%H%M%S}",
                                   loaded ? loaded->plan.name : "flight", fmt::localtime(std::time(nullptr)));
  const std::optional<flight::LiveOptions> of_live = ReadLive(a.live, mistakes);
  CheckWritableFolder(*options.folder, "--out", mistakes);
  mistakes.ThrowIfAny();
  flight::LoadedPlan& plan = *loaded;
  const WriterLock lock = LockFolder(*options.folder);
  const std::unique_ptr<flight::Live> live = MakeLive(of_live);

  const std::atomic<bool>& interrupted = EndInGoodOrder();
  std::signal(SIGPIPE, SIG_IGN);  // nor may it end a flight that nobody reads what it prints
  Print(stdout, fmt::format("{}  {} by {}, camera {}\n", records::LiveMode(false, a.dry_run), plan.plan.name,
                            a.autopilot, fmt::join(a.cameras, ", ")));
  PrintLive(live.get());
  options.live = live.get();
  options.limits = aircraft.safety;
  options.pilot_untold = aircraft.pilot_untold;
  options.dry_run = a.dry_run;
  options.video = !a.no_video;
  options.images = a.images;
  options.max_s = a.for_s.value_or(plan.plan.duration_s);
  options.interrupted = &interrupted;
  options.aircraft = ToYaml(aircraft);
  options.flown_with = FlownWith(a, options.max_s);

  std::optional<vision::LiveCamera> camera;
  camera.emplace(vision::SourceAt(address), by_ground ? aircraft.ground_camera : aircraft.camera);
  std::optional<vision::LiveCamera> ground;
  std::optional<flight::LiveGroundCamera> beside;
  flight::PacingGroundCamera pacing;
  if (ground_address) {
    ground.emplace(vision::SourceAt(*ground_address), aircraft.ground_camera);
    plan.parts.ground->stream = &beside.emplace(*ground);
  } else if (by_ground) {
    plan.parts.ground->stream = &pacing;
    options.seen = [&pacing](const vision::Frame& frame) { pacing.Give(frame); };
  }
  flight::PreFlightOptions check;
  check.ground = ground ? &*ground : nullptr;
  check.pilot_untold = aircraft.pilot_untold;
  check.interrupted = &interrupted;
  check.wait_s = a.wait_s.value_or(flight::kWait_s);
  std::vector<flight::CheckItem> items;
  {
    Waiting waiting(check.wait_s);
    check.waits = [&](const std::string& what, double waited_s) { waiting.Show(what, waited_s); };
    items = flight::PreFlight(plan, *camera, *link, check);
  }
  if (interrupted) {
    ReportNotFlown(plan, options, "interrupted during the check list");
    return false;
  }
  std::string list = "check list\n";
  for (const flight::CheckItem& item : items) {
    list += fmt::format("  {}\n", Text(item));
    options.flown_with.emplace_back("check", Text(item));
  }
  Print(stdout, list);
  options.checked = flight::AllOk(items);
  if (!options.checked && !a.dry_run) {
    ReportNotFlown(plan, options, "the check list is not met");
    return false;
  }
  // What was recorded is flown by from its first image.
  if (a.cameras.front().starts_with("file:")) camera.emplace(vision::SourceAt(address), aircraft.camera);

  const std::string mode = records::LiveMode(link->Health().simulated, a.dry_run);
  flight::FlyReport report;
  {
    Progress progress(mode);
    options.progress = [&](const control::VehicleState& state, const mission::Decision& decision,
                           const control::SafetyChange& safety) { progress.Show(state, decision, safety); };
    options.told = [&](const std::string& text) { progress.Tell(text); };
    report = flight::FlyAircraft(plan, *camera, *link, options);
  }
  Report(report, a, mode, ReportOf(*options.folder));
  Linger(live.get(), [&] { return !interrupted.load(); });
  return report.accomplished;
}

}  // namespace kestrel::app
