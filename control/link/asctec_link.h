// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "control/link/asctec_session.h"
#include "control/link/autopilot_link.h"

namespace kestrel::control {

// An AscTec low-level processor (Pelican, Hummingbird) on a serial device: 57600 baud, 8N1, no flow control.
// An AscTecSession with a thread and the monotonic clock. A device that cannot be opened, or fails, is opened
// again and again, and is named as an error meanwhile. It is this link's alone while it is open: whoever comes
// second is told that it is in use, and changes nothing of it.
//
// A state's time is when its IMU_CALCDATA began to leave: when the last byte came, less the time of the line.
// A USB adapter that holds bytes back (16 ms by default on FTDI's; latency_timer in sysfs) makes it late.
class AscTecLink final : public AutopilotLink {
 public:
  explicit AscTecLink(const AscTecOptions& options);
  ~AscTecLink() override;

  VehicleState State() const override;
  void Send(const Setpoint& setpoint) override;
  void Aid(const AttitudeAid& aid) override;  // not taken: an error
  LinkHealth Health() const override;
  void Silence() override;

 private:
  class Port;
  std::unique_ptr<Port> port_;
};

}  // namespace kestrel::control
