// SPDX-License-Identifier: Apache-2.0
#include "scenarios/serve_command.h"

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

#include "config/yaml_fields.h"
#include "geometry/tait_bryan.h"
#include "scenarios/end_signals.h"
#include "scenarios/files.h"
#include "scenarios/serve_flight.h"
#include "scenarios/serve_physics.h"
#include "sim/servers/afcs_server.h"
#include "sim/servers/ardupilot_physics.h"
#include "sim/servers/asctec_server.h"
#include "sim/servers/camera_server.h"
#include "sim/servers/mavlink_server.h"
#include "vision/rtp_stream.h"

namespace kestrel {
namespace {

std::atomic<bool> interrupted = false;
std::atomic<PhysicsServer*> stopped_physics = nullptr;  // by a signal

bool IsAddress(const std::string& text) {
  unsigned char bytes[sizeof(in6_addr)];
  return inet_pton(AF_INET, text.c_str(), bytes) == 1 || inet_pton(AF_INET6, text.c_str(), bytes) == 1;
}

bool OnLoopback(const std::string& address) { return address.starts_with("127.") || address == "::1"; }

// An address of this computer at which others reach it; where it has none, the loopback address.
std::string OwnAddress(bool version6) {
  std::string own = version6 ? "::1" : "127.0.0.1";
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return own;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    const int family = version6 ? AF_INET6 : AF_INET;
    if (!each->ifa_addr || each->ifa_addr->sa_family != family || (each->ifa_flags & IFF_LOOPBACK) != 0 ||
        (each->ifa_flags & IFF_UP) == 0)
      continue;
    std::array<char, NI_MAXHOST> text{};
    const socklen_t size = version6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in);
    if (getnameinfo(each->ifa_addr, size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) != 0)
      continue;
    own = text.data();
    break;
  }
  freeifaddrs(all);
  return own;
}

// To connect to, where a server listens at every address.
std::string Reachable(std::string where) {
  for (const char* everywhere : {"://0.0.0.0:", "://[::]:"}) {
    const std::size_t at = where.find(everywhere);
    if (at == std::string::npos) continue;
    const bool version6 = everywhere[3] == '[';
    const std::string own = OwnAddress(version6);
    where.replace(at, std::strlen(everywhere), version6 ? "://[" + own + "]:" : "://" + own + ":");
  }
  return where;
}

// Of "udp://ADDRESS:PORT"; empty: it is not on a network.
std::string AddressOf(const std::string& where) {
  const std::size_t from = where.find("://"), to = where.rfind(':');
  if (from == std::string::npos || to <= from) return {};
  std::string address = where.substr(from + 3, to - from - 3);
  if (address.starts_with('[')) address = address.substr(1, address.size() - 2);
  return address;
}

// As `kestrel fly` has it, which knows the size from its calibration.
std::string CameraAddressOf(const RtpStream& stream) {
  return fmt::format("{}://{}:{}", stream.coding == RtpStream::Coding::kRaw ? "raw" : "rtp", stream.host,
                     stream.port);
}

bool IsSeed(const std::string& text) {
  std::uint64_t seed = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), seed);
  return !text.empty() && read.ec == std::errc{} && read.ptr == text.data() + text.size();
}

constexpr double kLeast_s = 0.1, kMost_s = 36000;  // as a scenario's duration_s
bool InRange(double for_s) { return for_s >= kLeast_s && for_s <= kMost_s; }

// What is wrong with it is a mistake among others.
std::optional<LoadedScenario> Load(const std::string& scenario, const std::vector<std::string>& overrides,
                                   Mistakes& mistakes) {
  try {
    return LoadScenario(scenario, overrides);
  } catch (const InputError& e) {
    for (const std::string& message : e.messages) {
      const std::size_t colon = message.find(": ");
      mistakes.Add(message.substr(0, colon), "", colon == std::string::npos ? "" : message.substr(colon + 2));
    }
    return std::nullopt;
  }
}

std::optional<RtpStream> StreamOf(const ServeArguments& a) { return ParseRtpStream(a.camera); }

// ADDRESS:PORT; none: it is not that.
std::optional<std::pair<std::string, int>> PlaceIn(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  int port = -1;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + colon + 1, end, port);
  if (read.ec != std::errc{} || read.ptr != end || port < 0 || port > 65535) return std::nullopt;
  if (!IsAddress(text.substr(0, colon))) return std::nullopt;
  return std::pair(text.substr(0, colon), port);
}

// A stream to this computer, and a server where it goes: one of them would have what is the other's.
void CheckStreamsPort(const ServeArguments& a, Mistakes& mistakes) {
  const auto stream = StreamOf(a);
  if (!stream) return;
  const auto check = [&](const char* option, const std::string& address, int port) {
    if (port == stream->port && (OnLoopback(stream->host) || stream->host == address))
      mistakes.Add(option, "",
                   fmt::format("port {} is where the camera's stream goes; valid: another", port));
  };
  if (a.mavlink)
    check(a.mavlink_port ? "--mavlink-port" : "--mavlink", a.listen,
          a.mavlink_port.value_or(MavlinkServerOptions{}.port));
  if (a.afcs) {
    const auto place = PlaceIn(*a.afcs).value_or(std::pair(a.listen, AfcsServerOptions{}.port));
    check("--afcs", place.first, place.second);
  }
  if (a.physics == "ardupilot")  // PX4's is TCP
    check(a.physics_port ? "--physics-port" : "--physics", a.listen,
          a.physics_port.value_or(ArduPilotPhysicsParameters{}.port));
}

void Check(const ServeArguments& a, Mistakes& mistakes) {
  if (!a.seed.empty() && !IsSeed(a.seed))
    mistakes.Add("--seed", "",
                 fmt::format("'{}' is no seed; valid: a whole number from 0 to 2^64 - 1", a.seed));
  if (a.for_s && !InRange(*a.for_s))
    mistakes.Add("--for", "",
                 fmt::format("{:g} is out of range; valid: {:g} to {:g} s", *a.for_s, kLeast_s, kMost_s));
  if (a.camera != "none" && !StreamOf(a))
    mistakes.Add("--camera", "",
                 fmt::format("'{}' is no stream; valid: rtp:PORT, raw:PORT, rtp:ADDRESS:PORT, "
                             "raw:ADDRESS:PORT, none",
                             a.camera));
  if (!IsAddress(a.listen))
    mistakes.Add("--listen", "",
                 fmt::format("'{}' is no address; valid: one of this computer's, as numbers", a.listen));
  if (a.afcs && !a.afcs->empty() && !PlaceIn(*a.afcs))
    mistakes.Add("--afcs", "", fmt::format("'{}' is no place; valid: ADDRESS:PORT, or nothing", *a.afcs));
  CheckStreamsPort(a, mistakes);
  if (a.mavlink_port && !a.mavlink) mistakes.Add("--mavlink-port", "", "means nothing without --mavlink");
  if (a.pilot_off_at_s && !(*a.pilot_off_at_s >= 0))
    mistakes.Add("--pilot-off-at", "",
                 fmt::format("{:g} is no time of the flight; valid: 0 or more", *a.pilot_off_at_s));
  if (a.pilot_off_at_s && a.physics)
    mistakes.Add("--pilot-off-at", "",
                 "the autopilot that is served has the switch; valid: without --physics");
  if (a.physics_port && !a.physics) mistakes.Add("--physics-port", "", "means nothing without --physics");
  if (a.physics && (a.afcs || a.asctec || a.mavlink))
    mistakes.Add("--physics", "", "another autopilot flies, and the emulated one serves none; valid: alone");
  if (a.camera == "none" && !a.afcs && !a.asctec && !a.mavlink && !a.physics)
    mistakes.Add("serve", "",
                 "there is nothing to serve; valid: --afcs, --asctec, --mavlink, --physics, --camera");
}

std::string Warning(const std::string& what, const std::string& address) {
  return fmt::format(
      "  WARNING: {} is open beyond this computer ({}). These protocols have no authentication: whoever\n"
      "           reaches it can read and command.\n",
      what, address);
}

void Report(const Summary& s, const std::string& folder) {
  fmt::print("SIMULATOR  {}, seed {}: {}\n", s.scenario, s.seed,
             s.error.empty() ? s.outcome : "broke off: " + s.error);
  const auto value = [&](const char* name) {
    const auto found = s.metrics.find(name);
    return found != s.metrics.end() ? fmt::format("{:.4g}", found->second) : "none";
  };
  if (s.metrics.contains("touchdown_s"))
    fmt::print("  touch-down: error {} m, sink {} m/s, tilt {} deg, at {} s\n", value("touchdown_error_m"),
               value("touchdown_sink_m_s"), value("touchdown_tilt_deg"), value("touchdown_s"));
  for (const Criterion& c : s.criteria)
    fmt::print("  {:<4} {:<26} {:>11}   {} {:g}\n", c.passed ? "ok" : "NOT", c.name,
               std::isnan(c.value) ? "not reached" : fmt::format("{:.4g}", c.value),
               c.at_least ? "at least" : "at most", c.limit);
  const auto count = [&](const char* name) { return s.metrics.at(name); };
  fmt::print(
      "  setpoints: {:.0f} heard, {:.0f} of them followed; {:.0f} refused; {:.0f} messages not heeded\n",
      count("setpoints_heard"), count("setpoints_followed"), count("setpoints_refused"),
      count("messages_not_heeded"));
  fmt::print("  {:.1f} s of flight in {:.1f} s\n  {}\n", s.sim_s, s.wall_s, folder);
}

// The aircraft's platform for the camera, where there is one, a server turns it and it can be where the
// scenario mounts the camera.
std::optional<PanTilt> PlatformOf(const ServeArguments& a, const Scenario& scenario) {
  if (!a.afcs || !scenario.platform) return std::nullopt;
  const auto angles = AnglesOf(scenario.mount, *scenario.platform);
  if (!angles) return std::nullopt;
  return PanTilt(*scenario.platform, scenario.mount.position_m, *angles);
}

}  // namespace

CLI::App* AddServeCommand(CLI::App& app, ServeArguments& a) {
  CLI::App* serve = app.add_subcommand(
      "serve", "Fly the simulated aircraft in real time for any client, by real wires and a video stream");
  serve->add_option("scenario", a.scenario, "A name that `list` shows, or a YAML file")->required();
  serve->add_option("--seed", a.seed, "Of everything random, instead of the scenario's");
  serve->add_option("--set", a.overrides, "key.path=value, instead of the scenario's; may be repeated");
  serve->add_option("--afcs", a.afcs, "Rotomotion's AFCS by UDP, at ADDRESS:PORT or the usual place")
      ->expected(0, 1);
  serve->add_flag("--asctec", a.asctec, "Ascending Technologies' low-level processor, on a pseudo-terminal");
  serve->add_option("--mavlink", a.mavlink, "MAVLink 2 by UDP, as this autopilot speaks it")
      ->check(CLI::IsMember({"px4", "ardupilot"}));
  serve->add_option("--mavlink-port", a.mavlink_port, "Instead of the usual one")
      ->check(CLI::Range(0, 65535));
  serve
      ->add_option(
          "--physics", a.physics,
          "The physics for an autopilot of software in the loop, which moves the rotors itself: PX4's "
          "simulator protocol, or ArduPilot's JSON")
      ->check(CLI::IsMember({"px4", "ardupilot"}));
  serve->add_option("--physics-port", a.physics_port, "Instead of the usual one")
      ->check(CLI::Range(0, 65535));
  serve
      ->add_option("--camera", a.camera,
                   "rtp:PORT (MJPEG), raw:PORT (uncoded) on this computer, rtp:ADDRESS:PORT, "
                   "raw:ADDRESS:PORT to another, or none")
      ->capture_default_str();
  serve->add_option("--listen", a.listen, "Address of this computer at which servers listen")
      ->capture_default_str();
  serve->add_option(
      "--for", a.for_s,
      "How long, in s of real time, instead of the scenario's duration_s; with --physics, where a "
      "flight lasts until the autopilot leaves, until all ends");
  serve->add_option("--out", a.out, "Folder for the records (default results/runs/NAME-SEED-served)");
  serve->add_option("--pilot-off-at", a.pilot_off_at_s,
                    "When the pilot's switch takes the aircraft away, in s of the flight");
  serve->footer(
      "Exit status: 0 the criteria that the truth can judge were met, 1 they were not, or nobody flew it, 2 "
      "bad\n"
      "input, 3 it broke off.\n\nExamples:\n  kestrel serve landing --afcs --camera rtp:5600\n"
      "  kestrel serve landing --mavlink px4 --camera raw:5600 --for 120\n"
      "  kestrel serve hover --physics ardupilot --camera rtp:5600");
  return serve;
}

std::vector<NamedServer> MakeServers(const ServeArguments& a, const LoadedScenario& loaded, PanTilt* platform,
                                     Mistakes& mistakes) {
  std::vector<NamedServer> servers;
  // What cannot be had, an address in use or no pseudo-terminal, is a mistake of its option.
  const auto add = [&](const char* name, const char* option, auto make) {
    try {
      servers.push_back({name, make()});
    } catch (const InputError& e) {
      for (const std::string& message : e.messages) mistakes.Add(option, "", message);
    } catch (const std::exception& e) {
      mistakes.Add(option, "", e.what());
    }
  };
  if (a.afcs)
    add("afcs", "--afcs", [&] {
      AfcsServerOptions options;
      options.address = a.listen;
      if (const auto place = PlaceIn(*a.afcs)) std::tie(options.address, options.port) = *place;
      return std::make_unique<AfcsServer>(options, platform);
    });
  if (a.asctec)
    add("asctec", "--asctec", [&] { return std::make_unique<AscTecServer>(AscTecProcessorOptions{}); });
  if (a.mavlink)
    add("mavlink", "--mavlink", [&] {
      MavlinkServerOptions options;
      options.dialect = *a.mavlink;
      options.listen = a.listen;
      if (a.mavlink_port) options.port = *a.mavlink_port;
      constexpr int kQuadrotor = 2, kHelicopter = 4;  // MAV_TYPE
      options.type =
          std::holds_alternative<HelicopterParameters>(loaded.simulator.vehicle) ? kHelicopter : kQuadrotor;
      return std::make_unique<MavlinkServer>(options);
    });
  return servers;
}

std::string StartLines(const ServeArguments& a, const LoadedScenario& loaded,
                       const std::vector<NamedServer>& servers, const PanTilt* platform) {
  const Scenario& scenario = loaded.scenario;
  std::string lines = fmt::format(
      "SIMULATOR  {}, seed {}: {}\n", scenario.name, scenario.seed,
      a.physics ? fmt::format("at the autopilot's pace, flight after flight, until {}",
                              a.for_s ? fmt::format("{:g} s are over", *a.for_s) : "it is interrupted")
                : fmt::format("{:g} s in real time", scenario.duration_s));
  const auto stream = StreamOf(a);
  std::string camera;
  if (stream) {
    const cv::Size size(WidthPx(loaded.simulator.camera), HeightPx(loaded.simulator.camera));
    const double delay_s = scenario.image.latency_s + RtpDelay_s(stream->coding);
    lines += fmt::format("  camera   {}: {} x {}, {:g} Hz, to {} port {}\n", ToText(*stream), size.width,
                         size.height, scenario.image.rate_hz, stream->host, stream->port);
    lines += fmt::format("           received by: {}\n",
                         ReceivingPipeline(*stream, size, loaded.simulator.image.colour));
    lines += fmt::format(
        "           exposure_before_stamp_s: {:.3f} ({:.3f} of the camera, the rest of the "
        "stream)\n",
        delay_s, scenario.image.latency_s);
    if (!OnLoopback(stream->host)) lines += Warning("the camera's stream", stream->host);
    camera = fmt::format(" --camera {} --set-aircraft camera.exposure_before_stamp_s={:.3f}",
                         CameraAddressOf(*stream), delay_s);
  } else {
    lines += "  camera   none\n";
  }
  if (platform)
    lines += fmt::format(
        "  platform the camera is on it, at pan {:.0f}, tilt {:.0f} deg; the AFCS's PLATFORM turns it\n",
        Degrees(platform->angles().pan), Degrees(platform->angles().tilt));
  else if (a.afcs && scenario.platform)
    lines += "  platform none: it cannot hold the camera as the scenario's mount has it\n";
  for (const NamedServer& each : servers) {
    const std::string where = each.server->Where(), address = AddressOf(where);
    lines += fmt::format("  {:<8} {}\n", each.name, where);
    if (!address.empty() && !OnLoopback(address)) lines += Warning(each.name, address);
  }
  for (const NamedServer& each : servers) {
    std::string autopilot = fmt::format("{}:{}", each.name, Reachable(each.server->Where()));
    if (each.name == "mavlink") autopilot += " --take-control";
    if (each.name == "afcs") autopilot += " --pilot-untold";
    lines += fmt::format("  to fly it:  kestrel fly {}{} --autopilot {}\n", a.scenario, camera, autopilot);
  }
  return lines;
}

int ServeCommand(const ServeArguments& a) {
  std::vector<std::string> overrides = a.overrides;
  if (IsSeed(a.seed)) overrides.push_back("seed=" + a.seed);
  // Of a flight at an autopilot's pace it is the real time.
  if (a.for_s && InRange(*a.for_s) && !a.physics) overrides.push_back(fmt::format("duration_s={}", *a.for_s));
  Mistakes mistakes;
  Check(a, mistakes);
  const std::optional<LoadedScenario> read = Load(a.scenario, overrides, mistakes);
  if (!read) {
    if (!a.out.empty() && !a.physics) CheckWritableFolder(a.out, "--out", mistakes);
    mistakes.ThrowIfAny();
  }
  const LoadedScenario& loaded = *read;
  const Scenario& scenario = loaded.scenario;
  const std::string folder =
      a.out.empty() ? fmt::format("results/runs/{}-{}-served", scenario.name, scenario.seed) : a.out;
  if (!a.physics) CheckWritableFolder(folder, "--out", mistakes);
  mistakes.ThrowIfAny();
  std::optional<PanTilt> platform = PlatformOf(a, scenario);
  const std::vector<NamedServer> servers = MakeServers(a, loaded, platform ? &*platform : nullptr, mistakes);
  std::unique_ptr<PhysicsServer> physics;
  try {
    if (a.physics) physics = MakePhysics(*a.physics, a.listen, a.physics_port, loaded);
  } catch (const std::runtime_error& e) {
    mistakes.Add("--physics", "", e.what());
  }
  mistakes.ThrowIfAny();

  ServeOptions options;
  options.folder = folder;
  options.platform = platform ? &*platform : nullptr;
  options.pilot_off_at_s = a.pilot_off_at_s;
  for (const NamedServer& each : servers) options.servers.push_back(each.server.get());
  std::optional<CameraServer> camera;
  if (const auto stream = StreamOf(a)) {
    const CameraModel& model = loaded.simulator.camera;
    camera.emplace(*stream, cv::Size(WidthPx(model), HeightPx(model)), scenario.image.rate_hz,
                   loaded.simulator.image.colour);
    options.publish = [&](const Frame& frame) { camera->Publish(frame.image); };
  }
  options.begun = [&] {
    std::fputs(StartLines(a, loaded, servers, options.platform).c_str(), stdout);
    std::fflush(stdout);
  };
  // A terminal that has gone is no reason to break off a flight, and so no exception.
  options.say = [](const std::string& line) {
    std::puts(line.c_str());
    std::fflush(stdout);
  };
  options.go_on = [] { return !interrupted.load(); };
  // The first asks the flight to end in good order; a second one ends the program.
  stopped_physics = physics.get();
  OnEndSignals([](int) {
    interrupted = true;
    if (PhysicsServer* server = stopped_physics) server->Stop();
    EndOnNextSignal();
  });
  if (physics) {
    fmt::print("{}", StartLines(a, loaded, {}, nullptr));
    fmt::print("  physics  {}, for {}\n", physics->Where(), *a.physics);
    if (!OnLoopback(a.listen)) fmt::print("{}", Warning("the physics", a.listen));
    std::fflush(stdout);
    std::jthread end;
    if (a.for_s)
      end = std::jthread([&physics, for_s = *a.for_s](const std::stop_token& over) {
        std::mutex mutex;
        std::unique_lock lock(mutex);
        std::condition_variable_any never;
        never.wait_for(lock, over, std::chrono::duration<double>(for_s), [] { return false; });
        physics->Stop();
      });
    ServePhysics(loaded, *physics, options.publish, options.say);
    stopped_physics = nullptr;
    return 0;
  }
  const Summary summary = ServeFlight(loaded, options).summary;
  Report(summary, folder);
  if (!summary.complete) return 3;
  return summary.passed ? 0 : 1;
}

}  // namespace kestrel
