// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "base/yaml/fields.h"
#include "control/link/afcs_settings.h"
#include "control/link/autopilot_link.h"

namespace kestrel::control {

struct AfcsLinkOptions {
  std::string host = "127.0.0.1";
  int port = 2002;
  wire::AfcsSettings afcs;  // its teleop: as calibrated, so that what is asked for is what is flown
  double open_s = 0.25;
  double alive_s = 0.5;
  double silent_s = 1;
  double repeat_hz = 20;
  double platform_hz = 5;  // each is answered
};

inline void Fields(FieldVisitor& v, AfcsLinkOptions& o) {
  v({"host", "host name or IP address of the AFCS; kestrel fly takes that of --autopilot instead"}, o.host);
  v({"port", "UDP port of the AFCS; kestrel fly takes that of --autopilot instead"}, o.port, 1, 65535);
  v({"afcs", "what the numbers of the messages mean to the AFCS: to be calibrated with it"}, o.afcs);
  v({"open_s", "interval between attempts to open a session until one is acknowledged"}, o.open_s, 0.01,
    10.0);
  v({"alive_s", "interval of messages that keep the session open when nothing else is sent"}, o.alive_s, 0.01,
    10.0);
  v({"silent_s", "time without a state from the AFCS after which the session is opened anew"}, o.silent_s,
    0.05, 30.0);
  v({"repeat_hz", "rate at which the newest setpoint is repeated"}, o.repeat_hz, 4.0, 100.0);
  v({"platform_hz", "rate at which the newest command to the camera's pan-tilt platform is repeated"},
    o.platform_hz, 0.5, 50.0);
}

// A Rotomotion AFCS on UDP: AFCS-LIKE, UNVERIFIED AGAINST HARDWARE (control/wire/afcs.h). The session: OPEN
// until it is acknowledged, then states come by themselves, and it is closed with CLOSE. Who keeps quiet may
// be forgotten, so OPEN is said again now and then: what is known of it acknowledges that again. Nothing is
// authenticated; datagrams from any other address are not heard.
//
// Velocities are sent as TELEOP, places as FLY_TO, and either as often as kRepeat_s allows; attitudes cannot
// be. Of VehicleState, the messages of the thesis tell neither the mode nor whether the aircraft has landed:
// mode is taken from what is sent, landed from the rotor's speed.
//
// Nor do they tell of the pilot's switch (B.1.1 has no such field, and of the messages that might, AUTOPILOT
// and PPM, only sizes are known, and those in doubt): LinkHealth::pilot_allows is never there. It must be
// where the switch is that he takes over: at the servos.
class AfcsLink final : public AutopilotLink {
 public:
  // Throws InputError for a profile that is none and a host that is not known.
  explicit AfcsLink(const AfcsLinkOptions& options);
  ~AfcsLink() override;

  VehicleState State() const override;
  void Send(const Setpoint& setpoint) override;
  void Aid(const AttitudeAid& aid) override;  // not expressible
  LinkHealth Health() const override;
  void Silence() override;

  // Turns the camera's platform, as far as it has the axes, rad (TaitBryan), and goes on asking for it.
  void Point(double roll, double pitch, double yaw);          // from B
  void PointAbsolute(double roll, double pitch, double yaw);  // from N
  void PointAt(const Eigen::Vector3d& p_N);
  std::optional<wire::AfcsPlatform> Platform() const;  // the newest answer; none: none yet

  std::optional<PositionSetpoint> Desired() const;  // what it confirmed last that it will fly to
  std::optional<wire::AfcsGpsState> Gps() const;    // the newest

 private:
  struct Session;
  std::unique_ptr<Session> session_;
};

}  // namespace kestrel::control
