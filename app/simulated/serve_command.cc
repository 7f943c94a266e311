// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/serve_command.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <thread>
#include <tuple>

#include "app/option/colour.h"
#include "app/option/one_of.h"
#include "app/option/within.h"
#include "app/page/report_command.h"
#include "app/run/run_report.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/end_signals.h"
#include "flight/lockstep/lockstep_server.h"
#include "flight/served/serve_flight.h"
#include "flight/served/serve_physics.h"
#include "geometry/tait_bryan.h"
#include "sim/server/afcs_server.h"
#include "sim/server/asctec_server.h"
#include "sim/server/camera_server.h"
#include "sim/server/mavlink/mavlink_server.h"
#include "sim/server/physics/ardupilot_physics.h"
#include "vision/capture/rtp_stream.h"

namespace kestrel::app {
namespace {

std::atomic<sim::PhysicsServer*> stopped_physics = nullptr;  // by a signal
std::atomic<bool> physics_is_stopped = false;                // by a signal, or as its time is over

// What is wrong with it is a mistake among others.
std::optional<flight::LoadedScenario> Load(const std::string& scenario,
                                           const std::vector<std::string>& overrides, Mistakes& mistakes) {
  try {
    return flight::LoadScenario(scenario, overrides);
  } catch (const InputError& e) {
    mistakes.Add(e);
    return std::nullopt;
  }
}

void Report(const records::Summary& s, const std::string& report) {
  const bool colours = TakesColours(stdout);
  fmt::print("{}", Verdict(s, colours));
  const auto value = [&](const char* name) {
    const auto found = s.metrics.find(name);
    return found != s.metrics.end() ? fmt::format("{:.4g}", found->second) : "none";
  };
  if (s.metrics.contains("touchdown_s"))
    fmt::print("  touch-down: error {} m, sink {} m/s, tilt {} deg, at {} s\n", value("touchdown_error_m"),
               value("touchdown_sink_m_s"), value("touchdown_tilt_deg"), value("touchdown_s"));
  fmt::print("{}", CriteriaLines(s, colours));
  const auto count = [&](const char* name) { return s.metrics.at(name); };
  fmt::print(
      "  setpoints: {:.0f} received, {:.0f} of them followed; {:.0f} refused; {:.0f} messages ignored\n",
      count("setpoints_heard"), count("setpoints_followed"), count("setpoints_refused"),
      count("messages_not_heeded"));
  fmt::print("  {:.1f} s of flight in {:.1f} s\n  {}\n", s.sim_s, s.wall_s, report);
}

// The aircraft's platform for the camera, where there is one, a server turns it and it can be where the
// scenario mounts the camera.
std::optional<sim::PanTilt> PlatformOf(const flight::ServeArguments& a, const flight::Scenario& scenario) {
  if (!a.afcs || !scenario.platform) return std::nullopt;
  const auto angles = sim::AnglesOf(scenario.mount, *scenario.platform);
  if (!angles) return std::nullopt;
  return sim::PanTilt(*scenario.platform, scenario.mount.position_m, *angles);
}

// A terminal that has gone is no reason to break off a flight, and so no exception.
void Say(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

int ServeLockstep(const flight::ServeArguments& a, const std::vector<std::string>& overrides,
                  const flight::LoadedScenario& loaded) {
  flight::LockstepServerOptions options;
  options.address = a.lockstep->empty() ? flight::DefaultLockstepAddress() : *a.lockstep;
  options.timeout_s = a.lockstep_timeout_s;
  options.once = a.once;
  const std::atomic<bool>& interrupted = EndInGoodOrder();
  options.go_on = [&] { return !interrupted.load(); };
  flight::LockstepOptions flight;
  flight.scenario = a.scenario;
  flight.sim.overrides = overrides;
  flight.video = !a.no_video;
  flight.folder = [&, flights = 0](std::uint64_t seed) mutable {
    ++flights;
    if (a.out.empty()) return fmt::format("results/runs/{}-{}-lockstep", loaded.scenario.name, seed);
    return flights == 1 ? a.out : fmt::format("{}-{}", a.out, flights);
  };
  flight.say = Say;
  Mistakes mistakes;
  std::optional<flight::LockstepServer> server;
  try {
    const std::string wrong = flight::LockstepAddressMistake(options.address);
    if (!wrong.empty()) throw std::runtime_error(wrong);
    server.emplace(options, flight, loaded);
  } catch (const std::runtime_error& e) {
    mistakes.Add("--lockstep", "", e.what(), "valid: tcp:PORT, or the file of a Unix socket");
  }
  mistakes.ThrowIfAny();
  Say(fmt::format("SIMULATOR  {}, seed {}: in lockstep at {}, {}", loaded.scenario.name, loaded.scenario.seed,
                  server->where(),
                  a.once ? "for one client" : "client after client, until it is interrupted"));
  const std::optional<records::Summary> last = server->Serve();
  if (!a.once) return 0;
  if (!last) return 1;
  return !last->complete ? 3 : last->passed ? 0 : 1;
}

int ServePhysicsAlone(const flight::ServeArguments& a, const flight::LoadedScenario& loaded,
                      sim::PhysicsServer& physics, const flight::ServeOptions& served) {
  // The first asks the flight to end in good order; a second one ends the program.
  stopped_physics = &physics;
  physics_is_stopped = false;
  OnEndSignals([](int) {
    physics_is_stopped = true;
    if (sim::PhysicsServer* server = stopped_physics) server->Stop();
    EndOnNextSignal();
  });
  fmt::print("{}", flight::StartLines(a, loaded, {}, nullptr, physics.Where()));
  fmt::print("  motors   {}\n", physics.Motors());
  std::fflush(stdout);
  std::jthread end;
  if (a.for_s)
    end = std::jthread([&physics, for_s = *a.for_s](const std::stop_token& over) {
      std::mutex mutex;
      std::unique_lock lock(mutex);
      std::condition_variable_any never;
      never.wait_for(lock, over, std::chrono::duration<double>(for_s), [] { return false; });
      physics_is_stopped = true;
      physics.Stop();
    });
  flight::PhysicsOptions options;
  options.publish = served.publish;
  options.say = served.say;
  options.folder = served.folder;
  options.video = !a.no_video;
  options.stopped = [] { return physics_is_stopped.load(); };
  options.over = [](const records::Summary& summary, const auto& folder) {
    const bool colours = TakesColours(stdout);
    Say(Verdict(summary, colours) + CriteriaLines(summary, colours) +
        (folder ? fmt::format("  {}", ReportOf(*folder)) : ""));
  };
  const int status = flight::StatusOf(flight::ServePhysics(loaded, physics, options));
  stopped_physics = nullptr;
  return status;
}

}  // namespace

CLI::App* AddServeCommand(CLI::App& app, ServeCommandArguments& a) {
  CLI::App* serve = app.add_subcommand("serve",
                                       "Fly the simulated aircraft for any client: in real time by real "
                                       "wires and a video stream, or in lockstep");
  serve->add_option("scenario", a.scenario, "A name that `list` shows, or a YAML file")
      ->type_name("SCENARIO")
      ->required();
  serve->add_option("--seed", a.seed, "Of everything random, instead of the scenario's");
  serve->add_option("--set", a.overrides, "key.path=value, instead of the scenario's; may be repeated")
      ->type_name("KEY=VALUE");
  serve->add_option("--afcs", a.afcs, "Rotomotion's AFCS by UDP, at ADDRESS:PORT or the usual place")
      ->expected(0, 1);
  serve->add_flag("--asctec", a.asctec, "Ascending Technologies' low-level processor, on a pseudo-terminal");
  serve->add_option("--mavlink", a.mavlink, "MAVLink 2 by UDP, as this autopilot speaks it")
      ->check(OneOf({"px4", "ardupilot"}));
  serve->add_option("--mavlink-port", a.mavlink_port, "Instead of the usual one")
      ->check(WholeNumber(0, 65535));
  serve
      ->add_option(
          "--physics", a.physics,
          "The physics for an autopilot of software in the loop, which moves the rotors itself: PX4's "
          "simulator protocol, or ArduPilot's JSON")
      ->check(OneOf({"px4", "ardupilot"}));
  serve->add_option("--physics-port", a.physics_port, "Instead of the usual one")
      ->check(WholeNumber(0, 65535));
  serve
      ->add_option("--camera", a.camera,
                   "rtp:PORT (MJPEG), raw:PORT (uncoded) on this computer, rtp:ADDRESS:PORT, "
                   "raw:ADDRESS:PORT to another, or none")
      ->capture_default_str();
  serve
      ->add_option("--ground-camera", a.ground_camera,
                   "Where the images of the scenario's camera on the ground go, in the same forms")
      ->capture_default_str();
  serve->add_option("--listen", a.listen, "Address of this computer at which servers listen")
      ->capture_default_str();
  serve->add_option(
      "--for", a.for_s,
      "How long, in s of real time, instead of the scenario's duration_s; with --physics, where a "
      "flight lasts until the autopilot leaves, until all ends");
  serve
      ->add_option(
          "--lockstep", a.lockstep,
          "One program is the flight code, and time waits for it: by the Unix socket at this file, or "
          "at tcp:PORT of this computer; default a file of this user's (docs/guide/lockstep.md)")
      ->expected(0, 1)
      ->type_name("ADDRESS");
  serve->add_option("--lockstep-timeout", a.lockstep_timeout_s,
                    "How long, in s, its client may say nothing; for ever if not given");
  serve->add_flag("--once", a.once, "With --lockstep: end when the first client has gone");
  serve->add_flag("--no-video", a.no_video, "With --lockstep or --physics: leave out video.mp4");
  AddLiveOptions(*serve, a.live, false);
  serve
      ->add_option(
          "--out", a.out,
          "Folder for the records (default results/runs/NAME-SEED-served, in lockstep "
          "NAME-SEED-lockstep, with --physics NAME-SEED-physics); of a further flight in lockstep or "
          "with --physics DIR-2")
      ->type_name("DIR");
  serve->add_option("--pilot-off-at", a.pilot_off_at_s,
                    "When the pilot's switch takes the aircraft away, in s of the flight");
  serve->footer(
      "Exit status: 0 the criteria that the truth can judge were met, 1 they were not, or nobody flew it, 2 "
      "bad\n"
      "input, 3 it broke off. With --physics 0: all flights that left the ground have met "
      "them.\n\nExamples:\n  kestrel serve "
      "landing --afcs --camera rtp:5600\n"
      "  kestrel serve landing --mavlink px4 --camera raw:5600 --for 120\n"
      "  kestrel serve hover --physics ardupilot --camera rtp:5600\n"
      "  kestrel serve landing --lockstep tcp:4573");
  return serve;
}

int ServeCommand(const ServeCommandArguments& a) {
  std::vector<std::string> overrides = a.overrides;
  if (flight::IsSeed(a.seed)) overrides.push_back("seed=" + a.seed);
  // Of a flight at an autopilot's pace it is the real time.
  if (a.for_s && flight::InRange(*a.for_s) && !a.physics)
    overrides.push_back(fmt::format("duration_s={}", *a.for_s));
  Mistakes mistakes;
  flight::CheckArguments(a, mistakes);
  const std::optional<flight::LiveOptions> of_live = ReadLive(a.live, mistakes);
  if (a.live.port && (a.lockstep || a.physics))
    mistakes.Add("--live", "", fmt::format("is not shown with {}", a.lockstep ? "--lockstep" : "--physics"),
                 "valid: with --afcs, --asctec, --mavlink or --camera");
  const std::optional<flight::LoadedScenario> read = Load(a.scenario, overrides, mistakes);
  if (!read) {
    if (!a.out.empty()) CheckWritableFolder(a.out, "--out", mistakes);
    mistakes.ThrowIfAny();
  }
  const flight::LoadedScenario& loaded = *read;
  if (a.lockstep) {
    if (!a.out.empty()) CheckWritableFolder(a.out, "--out", mistakes);
    mistakes.ThrowIfAny();
    return ServeLockstep(a, overrides, loaded);
  }
  const flight::Scenario& scenario = loaded.scenario;
  const std::string folder = a.out.empty() ? fmt::format("results/runs/{}-{}-{}", scenario.name,
                                                         scenario.seed, a.physics ? "physics" : "served")
                                           : a.out;
  CheckWritableFolder(folder, "--out", mistakes);
  if (a.ground_camera != "none" && !loaded.simulator.ground)
    mistakes.Add("--ground-camera", "",
                 fmt::format("the scenario '{}' has no camera on the ground", scenario.name),
                 "valid: none, or a scenario of a mission with one");
  if (a.physics) flight::CheckPhysicsFaults(*a.physics, loaded, mistakes);
  mistakes.ThrowIfAny();
  std::optional<sim::PanTilt> platform = PlatformOf(a, scenario);
  const std::vector<flight::NamedServer> servers =
      flight::MakeServers(a, loaded, platform ? &*platform : nullptr, mistakes);
  std::unique_ptr<sim::PhysicsServer> physics;
  try {
    if (a.physics) physics = flight::MakePhysics(*a.physics, a.listen, a.physics_port, loaded);
  } catch (const std::runtime_error& e) {
    mistakes.Add("--physics", "", e.what());
  }
  mistakes.ThrowIfAny();

  flight::ServeOptions options;
  options.folder = folder;
  options.platform = platform ? &*platform : nullptr;
  options.pilot_off_at_s = a.pilot_off_at_s;
  for (const flight::NamedServer& each : servers) options.servers.push_back(each.server.get());
  std::optional<sim::CameraServer> camera;
  if (const auto stream = flight::StreamOf(a)) {
    const vision::CameraModel& model = loaded.simulator.camera;
    camera.emplace(*stream, cv::Size(vision::WidthPx(model), vision::HeightPx(model)), scenario.image.rate_hz,
                   loaded.simulator.image.colour);
    options.publish = [&](const vision::Frame& frame) { camera->Publish(frame.image); };
  }
  std::optional<sim::CameraServer> ground;
  if (const auto stream = flight::GroundStreamOf(a)) {
    const sim::GroundCameraParameters& of_ground = *loaded.simulator.ground;
    ground.emplace(*stream, cv::Size(vision::WidthPx(of_ground.camera), vision::HeightPx(of_ground.camera)),
                   of_ground.view.image.rate_hz, true);
    options.publish_ground = [&](const vision::Frame& frame) { ground->Publish(frame.image); };
  }
  options.begun = [&] {
    std::fputs(flight::StartLines(a, loaded, servers, options.platform).c_str(), stdout);
    std::fflush(stdout);
  };
  options.say = Say;
  if (physics) return ServePhysicsAlone(a, loaded, *physics, options);
  const std::atomic<bool>& interrupted = EndInGoodOrder();
  options.go_on = [&] { return !interrupted.load(); };
  const std::unique_ptr<flight::Live> live = MakeLive(of_live);
  PrintLive(live.get());
  options.live = live.get();
  const records::Summary summary = flight::ServeFlight(loaded, options).summary;
  Report(summary, ReportOf(folder));
  Linger(live.get(), options.go_on);
  if (!summary.complete) return 3;
  return summary.passed ? 0 : 1;
}

}  // namespace kestrel::app
