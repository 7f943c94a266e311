// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/wire/mavlink_messages.h"
#include "tests/sim/server/wire_peer.h"
#include "tests/sim/test_pilot.h"

namespace kestrel::sim {

// What PX4 does at its end of the simulator protocol, as its source has it: connects, asks for the truth,
// says that it is there, and answers each HIL_SENSOR.
class Px4Peer {
 public:
  explicit Px4Peer(const std::string& where) : wire_(where) {
    control::wire::mavlink::CommandLong ask;  // SET_MESSAGE_INTERVAL of HIL_STATE_QUATERNION: 5 ms
    ask.command = 511, ask.param1 = 115, ask.param2 = 5e3F;
    Send(ask);
    control::wire::mavlink::Heartbeat here;
    here.autopilot = 12;
    Send(here);
  }

  bool Send(const control::wire::mavlink::Message& message) { return wire_.Send(sender_.Encode(message)); }
  const WirePeer& wire() const { return wire_; }

  // The next message of the kind; those before it are passed over, but for what `other` is told. None: the
  // connection is closed.
  template <class M>
  std::optional<M> Await(const std::function<void(const control::wire::mavlink::Message&)>& other = {}) {
    for (;;) {
      while (!waiting_.empty()) {
        const control::wire::mavlink::Message message = waiting_.front();
        waiting_.pop_front();
        if (const auto* m = std::get_if<M>(&message)) return *m;
        if (other) other(message);
      }
      const control::wire::Bytes bytes = wire_.Receive();
      if (bytes.empty()) return std::nullopt;
      for (const control::wire::mavlink::Frame& frame : parser_.Stream(bytes))
        if (const auto message = control::wire::mavlink::Decode(frame)) waiting_.push_back(*message);
    }
  }
  bool Waiting(int within_ms) const { return !waiting_.empty() || wire_.Readable(within_ms); }

  bool Answer(std::uint64_t time_usec, const std::array<double, kMaxRotors>& commands, bool armed = true,
              bool lockstep = true) {
    control::wire::mavlink::HilActuatorControls controls;
    controls.time_usec = time_usec;
    controls.flags = lockstep ? 1 : 0;
    controls.mode = static_cast<std::uint8_t>(1 | (armed ? 128 : 0));
    for (std::size_t i = 0; i < commands.size(); ++i) controls.controls[i] = static_cast<float>(commands[i]);
    return Send(controls);
  }

 private:
  WirePeer wire_;
  control::wire::mavlink::Sender sender_{1, 1};
  control::wire::mavlink::Parser parser_{control::wire::mavlink::Formats()};
  std::deque<control::wire::mavlink::Message> waiting_;
};

// Where it is, by HIL_SENSOR and HIL_GPS alone. It stands still for the first second.
class HilEstimator {
 public:
  static constexpr double kStill_s = 1;

  void Take(const control::wire::mavlink::HilGps& gps) {
    if (!home_) home_ = gps;
    constexpr double kMetresPerDegree = 111200;  // of latitude, here; to a few parts in a thousand
    const Eigen::Vector2d p(
        (gps.lat - home_->lat) * 1e-7 * kMetresPerDegree,
        (gps.lon - home_->lon) * 1e-7 * kMetresPerDegree * std::cos(Radians(home_->lat * 1e-7)));
    state_.p_N.head<2>() += 0.3 * (p - state_.p_N.head<2>());
    state_.v_N.head<2>() += 0.3 * (Eigen::Vector2d(gps.vn, gps.ve) * 0.01 - state_.v_N.head<2>());
  }

  void Take(const control::wire::mavlink::HilSensor& s) {
    const double t_s = static_cast<double>(s.time_usec) * 1e-6, dt_s = t_s - t_s_;
    t_s_ = t_s;
    const Eigen::Vector3d force(s.xacc, s.yacc, s.zacc), w(s.xgyro, s.ygyro, s.zgyro);
    if (t_s <= kStill_s) {
      force_sum_ += force, w_sum_ += w, ++still_;
      if ((s.fields_updated & 512) != 0) pressure_sum_ += s.abs_pressure, ++pressures_;
      if ((s.fields_updated & 64) != 0) field_ = {s.xmag, s.ymag, s.zmag};
      state_.R_NA = HeadingRotation(-std::atan2(field_.y(), field_.x()));
      return;
    }
    state_.w_A = w - w_sum_ / still_;
    state_.R_NA = (state_.R_NA * FromRotationVector(state_.w_A * dt_s)).normalized();
    const Eigen::Vector3d bias = force_sum_ / still_ - Eigen::Vector3d(0, 0, -9.80665);
    const Eigen::Vector3d a_N = state_.R_NA * (force - bias) + Eigen::Vector3d(0, 0, 9.80665);
    state_.v_N += dt_s * a_N;
    state_.p_N += dt_s * state_.v_N;
    if ((s.fields_updated & 512) != 0) {
      // The pressure falls by rho g for each metre: 1.15 kg/m3 at some 650 m.
      const double height = (pressure_sum_ / pressures_ - s.abs_pressure) * 100 / (1.15 * 9.80665);
      const double error = -height - state_.p_N.z();
      state_.p_N.z() += 0.05 * error;
      state_.v_N.z() += 0.05 * error;
    }
  }
  const PilotState& state() const { return state_; }
  double t_s() const { return t_s_; }

 private:
  static Eigen::Quaterniond FromRotationVector(const Eigen::Vector3d& r) {
    return r.norm() > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(r.norm(), r.normalized()))
                        : Eigen::Quaterniond::Identity();
  }

  PilotState state_;
  double t_s_ = 0;
  std::optional<control::wire::mavlink::HilGps> home_;
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero(), w_sum_ = Eigen::Vector3d::Zero(), field_{1, 0, 0};
  double pressure_sum_ = 0;
  int still_ = 0, pressures_ = 0;
};

}  // namespace kestrel::sim
