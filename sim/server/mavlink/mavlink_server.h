// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "sim/server/autopilot_server.h"
#include "sim/server/mavlink/mavlink_vehicle.h"

namespace kestrel::sim {

// MAVLink 2 over UDP: MavlinkVehicle behind a socket. The session is that of the address from which a
// heartbeat comes first, or of options.peer; nothing is taken from any other until, in the first case, that
// one has been silent for kSilent_s. Another that would open one is told so by STATUSTEXT, once a second.
class MavlinkServer final : public AutopilotServer {
 public:
  static constexpr double kSilent_s = 3;
  static constexpr double kTellAgain_s = 1;

  // Throws InputError if an address cannot be understood or listened on.
  explicit MavlinkServer(const MavlinkServerOptions& options);
  ~MavlinkServer() override;

  void Serve(double now_s, control::Autopilot& aircraft) override;
  void SetPilot(bool allows) override;
  const WireCounts& Received() const override { return vehicle_.received(); }
  std::string Where() const override;

 private:
  struct Wire;
  std::unique_ptr<Wire> wire_;
  MavlinkVehicle vehicle_;
};

}  // namespace kestrel::sim
