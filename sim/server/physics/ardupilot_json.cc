// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/ardupilot_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <span>
#include <utility>

namespace kestrel::sim::ardupilot {
namespace {

using control::wire::Append;
using control::wire::Reader;

constexpr std::uint16_t kMagic16 = 18458, kMagic32 = 29569;
constexpr std::size_t kHeader = 8, kLongestRanges = 6, kLongestRc = 12;

// ArduPilot searches for the names: a name that is part of another one must come first ("velocity" before
// "velocity_wind"), and nothing may stand between colon and value.
class Line {
 public:
  void Add(double value) {
    finite_ = finite_ && std::isfinite(value);
    fmt::format_to(std::back_inserter(text_), "{}", value);
  }
  void Add(const Eigen::Vector3d& v) { AddList({v.x(), v.y(), v.z()}); }
  void Add(const Eigen::Quaterniond& q) { AddList({q.w(), q.x(), q.y(), q.z()}); }
  void Add(const char* text) { text_ += text; }
  template <class Value>
  void Add(const char* name, const Value& value) {
    fmt::format_to(std::back_inserter(text_), "\"{}\":", name);
    Add(value);
  }
  std::optional<std::string> Release() && {
    if (!finite_) return std::nullopt;
    return std::move(text_);
  }

 private:
  void AddList(std::initializer_list<double> values) {
    const char* before = "[";
    for (const double value : values) {
      Add(before), before = ",";
      Add(value);
    }
    Add("]");
  }
  std::string text_;
  bool finite_ = true;
};

}  // namespace

std::optional<ServoPacket> DecodeServoPacket(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  ServoPacket packet;
  const auto magic = reader.Read<std::uint16_t>();
  if (magic != kMagic16 && magic != kMagic32) return std::nullopt;
  packet.channels = magic == kMagic16 ? 16 : 32;
  if (bytes.size() != kHeader + 2 * static_cast<std::size_t>(packet.channels)) return std::nullopt;
  packet.frame_rate_hz = reader.Read<std::uint16_t>();
  packet.frame_count = reader.Read<std::uint32_t>();
  for (std::uint16_t& pwm : std::span(packet.pwm_us).first(static_cast<std::size_t>(packet.channels)))
    pwm = reader.Read<std::uint16_t>();
  return packet;
}

control::wire::Bytes EncodeServoPacket(const ServoPacket& packet) {
  control::wire::Bytes bytes;
  Append(bytes, packet.channels == 16 ? kMagic16 : kMagic32);
  Append(bytes, packet.frame_rate_hz);
  Append(bytes, packet.frame_count);
  for (const std::uint16_t pwm : std::span(packet.pwm_us).first(static_cast<std::size_t>(packet.channels)))
    Append(bytes, pwm);
  return bytes;
}

ServoEvent ServoSequence::Classify(std::uint32_t frame_count) {
  const std::optional<std::uint32_t> last = std::exchange(last_, frame_count);
  if (!last) return ServoEvent::kReset;
  const std::uint32_t steps = frame_count - *last;  // modulo 2^32: the count may go round
  if (steps == 0) return ServoEvent::kRepeat;
  if (steps >= 1U << 31) return ServoEvent::kReset;
  missed_ += steps - 1;
  return ServoEvent::kNext;
}

std::optional<std::string> StateLine(const PhysicsState& state) {
  Line line;
  line.Add("\n{");
  line.Add("timestamp", state.t_s);
  line.Add(",\"imu\":{");
  line.Add("gyro", state.w_B);
  line.Add(",");
  line.Add("accel_body", state.specific_force_B);
  line.Add("},");
  line.Add("position", state.p_N);
  line.Add(",");
  line.Add("quaternion", state.R_NB);
  line.Add(",");
  line.Add("velocity", state.v_N);
  for (std::size_t i = 0; i < std::min(state.ranges_m.size(), kLongestRanges); ++i) {
    line.Add(",");
    line.Add(fmt::format("rng_{}", i + 1).c_str(), state.ranges_m[i]);
  }
  if (state.wind_N) {
    line.Add(",");
    line.Add("velocity_wind", *state.wind_N);
  }
  if (state.airspeed_m_s) {
    line.Add(",");
    line.Add("airspeed", *state.airspeed_m_s);
  }
  if (!state.rc_us.empty()) {
    line.Add(",\"rc\":{");
    for (std::size_t i = 0; i < std::min(state.rc_us.size(), kLongestRc); ++i) {
      if (i > 0) line.Add(",");
      line.Add(fmt::format("rc_{}", i + 1).c_str(), static_cast<double>(state.rc_us[i]));
    }
    line.Add("}");
  }
  line.Add("}\n");
  return std::move(line).Release();
}

}  // namespace kestrel::sim::ardupilot
