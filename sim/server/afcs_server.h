// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/yaml/fields.h"
#include "control/link/afcs_settings.h"
#include "sim/camera/pan_tilt.h"
#include "sim/server/autopilot_server.h"
#include "sim/server/geodetic_origin.h"

namespace kestrel::sim {

struct AfcsServerOptions {
  std::string address = "127.0.0.1";  // to listen on
  int port = 2002;                    // 0: any that is free
  control::wire::AfcsSettings afcs;   // its teleop: what the aircraft makes of commands
  double state_hz = 50, gps_hz = 4;
  double session_s = 3;     // a peer that is silent for longer is forgotten, and another may open
  double rotor_rpm = 1500;  // while it flies; on the ground it stands still
  int satellites = 10;      // in use
  std::optional<GeodeticOrigin> origin;  // none: GPS tells raw places in N, as AFCS 2.5 does
};

inline void Fields(FieldVisitor& v, AfcsServerOptions& o) {
  v({"address", "address to listen on"}, o.address);
  v({"port", "UDP port to listen on; 0: any that is free"}, o.port, 0, 65535);
  v({"afcs", "layout and scales of the messages"}, o.afcs);
  v({"state_hz", "state messages in a second"}, o.state_hz, 1.0, 500.0);
  v({"gps_hz", "GPS messages in a second"}, o.gps_hz, 0.1, 50.0);
  v({"session_s", "silence after which a peer's session ends, and another may open one"}, o.session_s, 0.1,
    3600.0);
  v({"rotor_rpm", "rotor speed that is reported in flight"}, o.rotor_rpm, 0.0, 65535.0);
  v({"satellites", "number of satellites in use that is reported"}, o.satellites, 0, 100);
  v({"origin", "where the origin of N is on the earth; null: GPS messages hold places in N"}, o.origin);
}

// A Rotomotion AFCS: AFCS-LIKE, UNVERIFIED AGAINST HARDWARE (control/wire/afcs.h). OPEN begins a session and
// is acknowledged, each time that it is said; from then on states come at 50 Hz, what GPS says at 4 Hz, and
// who opened it is obeyed. CLOSE is echoed and ends it. While a session is open, others are not answered.
//
// The emulated autopilot knows neither magnetic field nor accelerations nor voltage: they read 0. The raw
// rates are those of the state. Latitude and longitude are in degrees; none of this is known of the product.
// A setpoint that no aircraft could follow, farther than 1e6 in any unit, is not obeyed; nor is any while the
// pilot's switch is off, and then FLY_TO is not answered either.
class AfcsServer final : public AutopilotServer {
 public:
  // platform: of the camera, which answers PLATFORM; null: there is none. It must outlive the server.
  // Throws InputError for a profile that is none and an address on which it cannot listen.
  explicit AfcsServer(const AfcsServerOptions& options, PanTilt* platform = nullptr);
  ~AfcsServer() override;

  void Serve(double now_s, control::Autopilot& aircraft) override;
  void SetPilot(bool allows) override;
  const WireCounts& Received() const override;
  std::string Where() const override;

 private:
  struct Session;
  std::unique_ptr<Session> session_;
};

}  // namespace kestrel::sim
