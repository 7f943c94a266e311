// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/gravity.h"
#include "control/wire/bytes.h"

// ArduPilot's "JSON" interface to a physics simulation (`--model JSON:127.0.0.1`): servo outputs come in as
// little packets on UDP port 9002, each is answered with the state as a line of text. Source: ArduPilot's
// libraries/SITL/examples/JSON/readme.md.
namespace kestrel::sim::ardupilot {

struct ServoPacket {
  std::uint16_t frame_rate_hz = 0;  // the physics steps that are asked for in a second
  std::uint32_t frame_count = 0;
  int channels = 16;                       // or 32
  std::array<std::uint16_t, 32> pwm_us{};  // zeros beyond channels
};

// None: not one, by its length or its first bytes.
std::optional<ServoPacket> DecodeServoPacket(std::span<const std::uint8_t> bytes);
// What ArduPilot sends.
control::wire::Bytes EncodeServoPacket(const ServoPacket& packet);

// What to do about a packet. ArduPilot waits for every answer; if it is long in coming, it sends the packet
// again.
enum class ServoEvent {
  kNext,    // step on and answer
  kRepeat,  // answer as before: its answer was lost or late
  kReset,   // the first one, or ArduPilot began anew: so must the flight
};

class ServoSequence {
 public:
  ServoEvent Classify(std::uint32_t frame_count);
  std::uint64_t missed() const { return missed_; }  // packets that never came

 private:
  std::optional<std::uint32_t> last_;
  std::uint64_t missed_ = 0;
};

struct PhysicsState {
  double t_s = 0;                                 // since any moment; steps of 0.1 s and more do not count
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  // rad/s
  Eigen::Vector3d specific_force_B = {0, 0, -kGravity_m_s2};  // m/s^2
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();              // m, from home
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();              // m/s
  Eigen::Quaterniond R_NB = Eigen::Quaterniond::Identity();
  // What is left out, ArduPilot makes up or does without.
  std::vector<double> ranges_m;           // of up to 6 range finders
  std::optional<Eigen::Vector3d> wind_N;  // m/s, of the air
  std::optional<double> airspeed_m_s;
  std::vector<int> rc_us;  // of up to 12 channels of the pilot's
};

// The line, between two line feeds. None: a number is not finite, which ArduPilot would take for a state.
std::optional<std::string> StateLine(const PhysicsState& state);

}  // namespace kestrel::sim::ardupilot
