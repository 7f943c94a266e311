// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "base/yaml/fields.h"
#include "control/autopilot.h"
#include "control/wire/asctec.h"
#include "control/wire/asctec_signs.h"
#include "sim/server/geodetic_origin.h"
#include "sim/server/wire_counts.h"

namespace kestrel::sim {

struct AscTecProcessorOptions {
  std::string signs = "asctec";    // or "ros": control/wire/asctec_signs.h
  bool gps_mode = true;            // the bits 4 and 5 of ctrl count; otherwise it is an attitude all the same
  double full_climb_m_s = 2;       // of that mode
  double command_timeout_s = 0.5;  // after which the serial interface is no longer said to be active
  double battery_v = 12;
  GeodeticOrigin origin = {};
};

inline void Fields(FieldVisitor& v, AscTecProcessorOptions& o) {
  v({"signs", "signs of the attitude commands: as AscTec's own manual or as its ROS driver has them"},
    o.signs, {"asctec", "ros"});
  v({"gps_mode", "whether the control word's bits for height and GPS control count"}, o.gps_mode);
  v({"full_climb_m_s", "vertical velocity of a full thrust command in height control"}, o.full_climb_m_s, 0.1,
    20.0);
  v({"command_timeout_s", "silence after which the serial interface no longer counts as active"},
    o.command_timeout_s, 0.05, 10.0);
  v({"battery_v", "battery voltage that is reported"}, o.battery_v, 0.0, 32.0);
  v({"origin", "where the origin of N is on the earth"}, o.origin);
}

// Bytes that take their time on a line of 57600 baud.
class SerialLine {
 public:
  // They leave at once if the line is free, otherwise after what is on it.
  void Put(double now_s, std::span<const std::uint8_t> bytes);
  control::wire::Bytes Receive(double now_s);  // what has arrived by now
  double free_s() const { return free_s_; }

  // As many wait for their turn, as in a driver's buffer; of more, the oldest are lost.
  static constexpr std::size_t kMax = 4096;

 private:
  std::deque<std::uint8_t> bytes_;
  std::deque<double> arrive_s_;  // one for each, in turn
  double free_s_ = -1e300;
};

// The AscTec low-level processor's end of its line, without a device: bytes in and out at the pace of 57600
// baud, setpoints to the aircraft. It speaks when it is asked; each frame holds the aircraft's state at the
// moment at which it begins to leave.
//
// Of what the wire says only the state of the aircraft is behind it. GPS_DATA is the state as well, with a
// fix and ten satellites; accelerations are those of an aircraft at rest; raw data, CTRL_OUT and the
// magnetometer are zero. Unverified, as of the real one nothing public tells: the order in which the frames
// of one request leave (by their bits), when each is sampled, what the R/C channels but the switch (the
// fifth) hold, lock, and what follows a time-out (here the aircraft's own holds the place, and the real one
// goes back to the pilot).
//
// CTRL_INPUT: followed with the lowest four bits of ctrl, as an attitude, or with bits 4 and 5, if the options
// say so, as a velocity; acknowledged always. Thrust 0 with full yaw for 0.3 s starts the motors of
// an aircraft that stands, and stops them: the emulated aircraft has no such command, so it takes off by
// itself to half a metre once thrust is given, and stops by sinking until its touch-down logic does it. An
// EMERGENCY_STOP is ignored, and is not acknowledged.
class AscTecProcessor {
 public:
  explicit AscTecProcessor(const AscTecProcessorOptions& options);

  void Receive(double now_s, std::span<const std::uint8_t> bytes);        // put on the line by the other end
  control::wire::Bytes Step(double now_s, control::Autopilot& aircraft);  // what has arrived at the other end
  void SetPilot(bool allows) { pilot_allows_ = allows; }
  const control::wire::LinkCounts& counts() const { return parser_.counts(); }
  const WireCounts& received() const { return counts_; }

 private:
  void CountSetpoint(const control::wire::CtrlInput& input);
  void Obey(double now_s, const control::wire::CtrlInput& input, control::Autopilot& aircraft);
  void Speak(double now_s, control::Autopilot& aircraft);
  control::wire::Bytes NextFrame(double now_s, const control::VehicleState& state);
  control::wire::LlStatus Status(double now_s, const control::VehicleState& state) const;
  control::wire::ImuCalcData Imu(const control::VehicleState& state) const;
  control::wire::GpsDataAdvanced Gps(const control::VehicleState& state) const;
  control::wire::RcData Radio() const;

  AscTecProcessorOptions options_;
  control::wire::AscTecSigns signs_;
  bool pilot_allows_ = true;

  SerialLine received_, sent_;
  control::wire::CommandParser parser_;
  WireCounts counts_;
  std::uint64_t damaged_ = 0;            // of the parser's refusals, as far as counted
  std::optional<double> quiet_since_s_;  // with something unread
  std::uint16_t asked_ = 0;              // request bits of frames that have not begun to leave
  double asked_s_ = 0;

  std::optional<double> commanded_s_;
  bool by_gps_ = false;
  bool idling_ = false;  // motors turn on the ground
  std::optional<double> sticks_since_s_, motors_since_s_;
  bool sticks_done_ = false;  // they must be let go before they count again
};

}  // namespace kestrel::sim
