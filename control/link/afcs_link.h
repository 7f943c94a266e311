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
  double open_s = 0.25;     // between OPENs until one is acknowledged
  double alive_s = 0.5;     // between OPENs that keep the session, when nothing else is sent
  double silent_s = 1;      // without a state for longer: the session is opened anew
  double repeat_hz = 20;    // of the newest setpoint
  double platform_hz = 5;   // of the newest command to the camera's platform; each is answered
};

inline void Fields(FieldVisitor& v, AfcsLinkOptions& o) {
  v("host", o.host);
  v("port", o.port, 1, 65535);
  v("afcs", o.afcs);
  v("open_s", o.open_s, 0.01, 10.0);
  v("alive_s", o.alive_s, 0.01, 10.0);
  v("silent_s", o.silent_s, 0.05, 30.0);
  v("repeat_hz", o.repeat_hz, 4.0, 100.0);
  v("platform_hz", o.platform_hz, 0.5, 50.0);
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
