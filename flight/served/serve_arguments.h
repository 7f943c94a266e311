// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "sim/camera/pan_tilt.h"
#include "sim/server/autopilot_server.h"
#include "vision/capture/rtp_stream.h"

namespace kestrel {
class Mistakes;
}

namespace kestrel::flight {

struct LoadedScenario;

// `kestrel serve`: the simulated aircraft, in real time or in lockstep, for any client. An absent option was not
// given.
struct ServeArguments {
  std::string scenario, seed, out, camera = "none", ground_camera = "none", listen = "127.0.0.1";
  std::vector<std::string> overrides;
  std::optional<std::string> afcs;  // ADDRESS:PORT; empty: the usual
  bool asctec = false;
  std::optional<std::string> mavlink;  // px4, ardupilot
  std::optional<int> mavlink_port;
  std::optional<std::string> physics;  // px4, ardupilot
  std::optional<int> physics_port;
  std::optional<double> for_s, pilot_off_at_s;
  std::optional<std::string> lockstep;  // at this address (flight/lockstep); empty: the usual
  std::optional<double> lockstep_timeout_s;
  bool once = false, no_video = false;
};

// What is wrong with them by themselves, whatever the scenario.
void CheckArguments(const ServeArguments& arguments, Mistakes& mistakes);
bool IsSeed(const std::string& text);
bool InRange(double for_s);
bool OnLoopback(const std::string& address);
std::optional<vision::RtpStream> StreamOf(const ServeArguments& arguments);
std::optional<vision::RtpStream> GroundStreamOf(const ServeArguments& arguments);
// That what listens at or sends to this address is open to others.
std::string Warning(const std::string& what, const std::string& address);

struct NamedServer {
  std::string name;  // "afcs", as `kestrel fly` has it
  std::unique_ptr<sim::AutopilotServer> server;
};

// The far ends that were asked for, listening. platform: of the camera, which AFCS turns; null: there is
// none. What cannot be had is a mistake.
std::vector<NamedServer> MakeServers(const ServeArguments& arguments, const LoadedScenario& loaded,
                                     sim::PanTilt* platform, Mistakes& mistakes);

// How to connect, line by line: where each server listens and the camera goes, a warning where that is not
// this computer alone, and the command line of `kestrel fly` for each. physics: where autopilots of software in the
// loop connect to (sim::PhysicsServer::Where), with the command line of theirs too; empty: nowhere.
std::string StartLines(const ServeArguments& arguments, const LoadedScenario& loaded,
                       const std::vector<NamedServer>& servers, const sim::PanTilt* platform,
                       const std::string& physics = {});

}  // namespace kestrel::flight
