// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/server/asctec_processor.h"
#include "sim/server/autopilot_server.h"

namespace kestrel::sim {

// An AscTecProcessor on a pseudo-terminal, which stands for its serial port: whoever may open the device, of
// this user alone, commands the aircraft. Bytes that nobody reads are lost, as on a line.
class AscTecServer final : public AutopilotServer {
 public:
  explicit AscTecServer(
      const AscTecProcessorOptions& options);  // throws std::system_error: no pseudo-terminal
  ~AscTecServer() override;
  AscTecServer(const AscTecServer&) = delete;
  AscTecServer& operator=(const AscTecServer&) = delete;

  void Serve(double now_s, control::Autopilot& aircraft) override;
  void SetPilot(bool allows) override { processor_.SetPilot(allows); }
  const WireCounts& Received() const override { return processor_.received(); }
  std::string Where() const override { return "serial:" + device_; }
  const control::wire::LinkCounts& counts() const { return processor_.counts(); }

 private:
  AscTecProcessor processor_;
  int master_ = -1, slave_ = -1;
  std::string device_;
};

}  // namespace kestrel::sim
