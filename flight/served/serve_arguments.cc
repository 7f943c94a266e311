// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_arguments.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>

#include <array>
#include <charconv>
#include <cstring>
#include <tuple>

#include "flight/load_plugins.h"
#include "flight/served/physics_lines.h"
#include "flight/simulated/scenario.h"
#include "geometry/tait_bryan.h"
#include "sim/server/afcs_server.h"
#include "sim/server/asctec_server.h"
#include "sim/server/mavlink/mavlink_server.h"
#include "sim/server/physics/ardupilot_physics.h"

namespace kestrel::flight {
namespace {

bool IsAddress(const std::string& text) {
  unsigned char bytes[sizeof(in6_addr)];
  return inet_pton(AF_INET, text.c_str(), bytes) == 1 || inet_pton(AF_INET6, text.c_str(), bytes) == 1;
}

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
std::string CameraAddressOf(const vision::RtpStream& stream) {
  return fmt::format("{}://{}:{}", stream.coding == vision::RtpStream::Coding::kRaw ? "raw" : "rtp",
                     stream.host, stream.port);
}

constexpr double kLeast_s = 0.1, kMost_s = 36000;  // as a scenario's duration_s
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
      mistakes.Add(option, "", fmt::format("port {} is where the camera's stream goes", port),
                   "valid: another");
  };
  if (a.mavlink)
    check(a.mavlink_port ? "--mavlink-port" : "--mavlink", a.listen,
          a.mavlink_port.value_or(sim::MavlinkServerOptions{}.port));
  if (a.afcs) {
    const auto place = PlaceIn(*a.afcs).value_or(std::pair(a.listen, sim::AfcsServerOptions{}.port));
    check("--afcs", place.first, place.second);
  }
  if (a.physics == "ardupilot")  // PX4's is TCP
    check(a.physics_port ? "--physics-port" : "--physics", a.listen,
          a.physics_port.value_or(sim::ArduPilotPhysicsParameters{}.port));
}

// Time waits for the client: what serves in real time has no place beside it.
void CheckLockstep(const ServeArguments& a, Mistakes& mistakes) {
  const std::vector<std::pair<const char*, bool>> of_lockstep = {
      {"--lockstep-timeout", a.lockstep_timeout_s.has_value()}, {"--once", a.once}};
  if (!a.lockstep) {
    for (const auto& [option, given] : of_lockstep)
      if (given) mistakes.Add(option, "", "means nothing without --lockstep");
    if (a.no_video && !a.physics)
      mistakes.Add("--no-video", "", "means nothing without --lockstep or --physics");
    return;
  }
  const ServeArguments usual;
  const std::vector<std::pair<const char*, bool>> of_real_time = {
      {"--afcs", a.afcs.has_value()},
      {"--asctec", a.asctec},
      {"--mavlink", a.mavlink.has_value()},
      {"--mavlink-port", a.mavlink_port.has_value()},
      {"--physics", a.physics.has_value()},
      {"--physics-port", a.physics_port.has_value()},
      {"--camera", a.camera != usual.camera},
      {"--ground-camera", a.ground_camera != usual.ground_camera},
      {"--listen", a.listen != usual.listen},
      {"--for", a.for_s.has_value()},
      {"--pilot-off-at", a.pilot_off_at_s.has_value()}};
  std::string beside;
  for (const auto& [option, given] : of_real_time)
    if (given) beside += fmt::format("{}{}", beside.empty() ? "" : ", ", option);
  if (!beside.empty())
    mistakes.Add("--lockstep", "", fmt::format("does not go with {}: time waits for its client", beside),
                 "valid: with --seed, --set, --out, --no-video, --once, --lockstep-timeout");
  if (a.lockstep_timeout_s && !(*a.lockstep_timeout_s > 0 && *a.lockstep_timeout_s <= kMost_s))
    mistakes.Add("--lockstep-timeout", "", fmt::format("{:g} is out of range", *a.lockstep_timeout_s),
                 fmt::format("valid: more than 0, to {:g} s", kMost_s));
}

}  // namespace

bool IsSeed(const std::string& text) {
  std::uint64_t seed = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), seed);
  return !text.empty() && read.ec == std::errc{} && read.ptr == text.data() + text.size();
}

bool OnLoopback(const std::string& address) { return address.starts_with("127.") || address == "::1"; }

bool InRange(double for_s) { return for_s >= kLeast_s && for_s <= kMost_s; }

std::optional<vision::RtpStream> StreamOf(const ServeArguments& a) {
  return vision::ParseRtpStream(a.camera);
}

std::optional<vision::RtpStream> GroundStreamOf(const ServeArguments& a) {
  return vision::ParseRtpStream(a.ground_camera);
}

std::string Warning(const std::string& what, const std::string& address) {
  return fmt::format(
      "  WARNING: {} is open beyond this computer ({}). These protocols have no authentication: whoever\n"
      "           reaches it can read and command.\n",
      what, address);
}

void CheckArguments(const ServeArguments& a, Mistakes& mistakes) {
  if (!a.seed.empty() && !IsSeed(a.seed))
    mistakes.Add("--seed", "", fmt::format("'{}' is no seed", a.seed),
                 "valid: a whole number from 0 to 2^64 - 1");
  CheckLockstep(a, mistakes);
  if (a.lockstep) return;
  if (a.for_s && !InRange(*a.for_s))
    mistakes.Add("--for", "", fmt::format("{:g} is out of range", *a.for_s),
                 fmt::format("valid: {:g} to {:g} s", kLeast_s, kMost_s));
  if (a.camera != "none" && !StreamOf(a))
    mistakes.Add("--camera", "", fmt::format("'{}' is no stream", a.camera),
                 "valid: rtp:PORT, raw:PORT, rtp:ADDRESS:PORT, raw:ADDRESS:PORT, none");
  if (a.ground_camera != "none" && !GroundStreamOf(a))
    mistakes.Add("--ground-camera", "", fmt::format("'{}' is no stream", a.ground_camera),
                 "valid: rtp:PORT, raw:PORT, rtp:ADDRESS:PORT, raw:ADDRESS:PORT, none");
  if (const auto stream = StreamOf(a), ground = GroundStreamOf(a);
      stream && ground && stream->port == ground->port && stream->host == ground->host)
    mistakes.Add("--ground-camera", "",
                 fmt::format("port {} is where the camera's stream goes", stream->port), "valid: another");
  if (a.ground_camera != "none" && a.physics)
    mistakes.Add("--ground-camera", "", "is not served with the physics alone", "valid: without --physics");
  if (!IsAddress(a.listen))
    mistakes.Add("--listen", "", fmt::format("'{}' is no address", a.listen),
                 "valid: one of this computer's, as numbers");
  if (a.afcs && !a.afcs->empty() && !PlaceIn(*a.afcs))
    mistakes.Add("--afcs", "", fmt::format("'{}' is no place", *a.afcs), "valid: ADDRESS:PORT, or nothing");
  CheckStreamsPort(a, mistakes);
  if (a.mavlink_port && !a.mavlink) mistakes.Add("--mavlink-port", "", "means nothing without --mavlink");
  if (a.pilot_off_at_s && !(*a.pilot_off_at_s >= 0))
    mistakes.Add("--pilot-off-at", "", fmt::format("{:g} is no time of the flight", *a.pilot_off_at_s),
                 "valid: 0 or more");
  if (a.pilot_off_at_s && a.physics)
    mistakes.Add("--pilot-off-at", "", "the autopilot that is served has the switch",
                 "valid: without --physics");
  if (a.physics_port && !a.physics) mistakes.Add("--physics-port", "", "means nothing without --physics");
  if (a.physics && (a.afcs || a.asctec || a.mavlink))
    mistakes.Add("--physics", "", "another autopilot flies, and the emulated one serves none",
                 "valid: alone");
  if (a.camera == "none" && !a.afcs && !a.asctec && !a.mavlink && !a.physics)
    mistakes.Add("serve", "", "there is nothing to serve",
                 "valid: --afcs, --asctec, --mavlink, --physics, --camera, --lockstep");
}

std::vector<NamedServer> MakeServers(const ServeArguments& a, const LoadedScenario& loaded,
                                     sim::PanTilt* platform, Mistakes& mistakes) {
  std::vector<NamedServer> servers;
  // What cannot be had, an address in use or no pseudo-terminal, is a mistake of its option.
  const auto add = [&](const char* name, const char* option, auto make) {
    try {
      servers.push_back({name, make()});
    } catch (const InputError& e) {
      mistakes.Add(e, option);
    } catch (const std::exception& e) {
      mistakes.Add(option, "", e.what());
    }
  };
  if (a.afcs)
    add("afcs", "--afcs", [&] {
      sim::AfcsServerOptions options;
      options.address = a.listen;
      if (const auto place = PlaceIn(*a.afcs)) std::tie(options.address, options.port) = *place;
      return std::make_unique<sim::AfcsServer>(options, platform);
    });
  if (a.asctec)
    add("asctec", "--asctec",
        [&] { return std::make_unique<sim::AscTecServer>(sim::AscTecProcessorOptions{}); });
  if (a.mavlink)
    add("mavlink", "--mavlink", [&] {
      sim::MavlinkServerOptions options;
      options.dialect = *a.mavlink;
      options.listen = a.listen;
      if (a.mavlink_port) options.port = *a.mavlink_port;
      constexpr int kQuadrotor = 2, kHelicopter = 4;  // MAV_TYPE
      options.type = std::holds_alternative<sim::HelicopterParameters>(loaded.simulator.vehicle) ? kHelicopter
                                                                                                 : kQuadrotor;
      return std::make_unique<sim::MavlinkServer>(options);
    });
  return servers;
}

std::string StartLines(const ServeArguments& a, const LoadedScenario& loaded,
                       const std::vector<NamedServer>& servers, const sim::PanTilt* platform,
                       const std::string& physics) {
  const Scenario& scenario = loaded.scenario;
  std::string lines = fmt::format(
      "SIMULATOR  {}, seed {}: {}\n", scenario.name, scenario.seed,
      a.physics ? fmt::format("at the autopilot's pace, flight after flight, until {}",
                              a.for_s ? fmt::format("{:g} s are over", *a.for_s) : "it is interrupted")
                : fmt::format("{:g} s in real time", scenario.duration_s));
  const auto stream = StreamOf(a);
  std::string camera;
  if (stream) {
    const cv::Size size(vision::WidthPx(loaded.simulator.camera), vision::HeightPx(loaded.simulator.camera));
    const double delay_s = scenario.image.latency_s + vision::RtpDelay_s(stream->coding);
    lines += fmt::format("  camera   {}: {} x {}, {:g} Hz, to {} port {}\n", vision::ToText(*stream),
                         size.width, size.height, scenario.image.rate_hz, stream->host, stream->port);
    lines += fmt::format("           received by: {}\n",
                         vision::ReceivingPipeline(*stream, size, loaded.simulator.image.colour));
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
  if (const auto ground = GroundStreamOf(a)) {
    const vision::CameraModel& model = loaded.simulator.ground->camera;
    const sim::ImageParameters& image = loaded.simulator.ground->view.image;
    const double delay_s = image.latency_s + vision::RtpDelay_s(ground->coding);
    lines += fmt::format("  ground   {}: {} x {}, {:g} Hz, to {} port {}\n", vision::ToText(*ground),
                         vision::WidthPx(model), vision::HeightPx(model), image.rate_hz, ground->host,
                         ground->port);
    if (!OnLoopback(ground->host)) lines += Warning("the stream of the camera on the ground", ground->host);
    camera += fmt::format(" --camera {} --set-aircraft ground_camera.exposure_before_stamp_s={:.3f}",
                          CameraAddressOf(*ground), delay_s);
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
  std::string fly = fmt::format("kestrel fly {}", a.scenario);
  for (const std::string& each : LoadedPlugins()) fly += fmt::format(" --plugin {}", each);
  fly += camera;
  for (const NamedServer& each : servers) {
    std::string autopilot = fmt::format("{}:{}", each.name, Reachable(each.server->Where()));
    if (each.name == "mavlink") autopilot += " --take-control";
    if (each.name == "afcs") autopilot += " --pilot-untold";
    lines += fmt::format("  to fly it:  {} --autopilot {}\n", fly, autopilot);
  }
  if (physics.empty()) return lines;
  lines += fmt::format("  physics  {}, for {}\n", physics, *a.physics);
  if (!OnLoopback(a.listen)) lines += Warning("the physics", a.listen);
  return lines + PhysicsLines(*a.physics, Reachable(physics), scenario.vehicle, stream ? fly : "");
}

}  // namespace kestrel::flight
