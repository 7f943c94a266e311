// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/ardupilot_physics.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "control/link/session_socket.h"
#include "sim/server/physics/ardupilot_json.h"
#include "sim/server/physics/gathered_readings.h"
#include "sim/server/physics/io_wait.h"
#include "sim/server/physics/motor_layout.h"

namespace kestrel::sim {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using Clock = std::chrono::steady_clock;

constexpr double kCoarseStep_s = 0.002;
constexpr double kLongest_s = 0.1;  // steps of this and more do not count for ArduPilot
constexpr int kLook_ms = 20;        // for Stop()

}  // namespace

struct ArduPilotPhysics::Impl {
  struct Received {
    udp::endpoint from;
    ardupilot::ServoPacket packet;
  };

  Impl(const ArduPilotPhysicsParameters& p, const AirframeParameters& aircraft)
      : parameters(p), motors(KnownMotorOrder(MultirotorOf(aircraft)), MultirotorOf(aircraft)) {
    const udp::endpoint here(ParseAddress(p.address), static_cast<std::uint16_t>(p.port));
    Listen("udp", here, [&] {
      boost::system::error_code error;
      socket.Open(here, error);
      if (error) throw boost::system::system_error(error);
    });
  }

  // Of this one; none: it says nothing that is understood.
  std::optional<Received> Read(const control::SessionSocket::Datagram& datagram) {
    const auto packet = ardupilot::DecodeServoPacket(datagram.bytes);
    if (packet) return Received{datagram.from, *packet};
    ++counts.refused;
    return std::nullopt;
  }

  // The next packet of the peer, or, when there is none or it is gone, of one who begins; none: Stop(). What
  // others send is looked at after all that came of the peer.
  std::optional<Received> Next() {
    while (!stop) {
      const Clock::time_point now =
          Clock::now();  // before its queue is empty, so that its silence is its own
      if (const auto datagram = socket.FromOwner()) {
        if (const auto received = Read(*datagram)) return received;
      } else if (const auto other = socket.FromOthers()) {
        if (socket.owner() && other->from != socket.owner() &&
            now - heard < std::chrono::duration<double>(parameters.gone_s)) {
          ++counts.refused;
          continue;
        }
        if (const auto received = Read(*other)) return received;
      } else {
        socket.Wait(kLook_ms);
      }
    }
    return std::nullopt;
  }

  void Open(const Received& first) {
    if (first.from != socket.owner()) socket.Own(first.from);
    sequence = {};
    sequence.Classify(first.packet.frame_count);
    Obey(first);
  }

  void Obey(const Received& received) {
    heard = Clock::now();
    owed = true;
    const ardupilot::ServoPacket& packet = received.packet;
    const double range_us = parameters.pwm_max_us - parameters.pwm_min_us;
    for (std::size_t i = 0; i < motors.order().rotor.size(); ++i)
      commands[i] = (packet.pwm_us[i] - parameters.pwm_min_us) / range_us;
    step_s = packet.frame_rate_hz > 0 ? 1.0 / packet.frame_rate_hz : 0;
  }

  bool Begin() {
    if (stop) return false;
    if (!owed) {
      const std::optional<Received> first = Next();
      if (!first) return false;
      Open(*first);
    }
    line.clear();
    gathered = {};
    ++counts.flights;
    return true;
  }

  void Answer() {
    socket.Send({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()}, *socket.owner());
    heard = Clock::now();  // who waits for an answer is not silent
  }

  std::optional<Actuation> Step(double dt_s, const SensorReadings& readings, const Truth& truth) {
    gathered.Add(readings);
    const double most = std::max(1.0, std::ceil(kLongest_s / dt_s - 1e-6) - 1);
    const double steps = std::clamp(std::round(step_s / dt_s), 1.0, most);
    if (gathered.steps() < steps) return motors.Speeds(commands, parameters.thrust_curvature);

    ardupilot::PhysicsState state;
    state.t_s = truth.t_s;
    const ImuSample imu = gathered.MeanImu();
    state.w_B = imu.w_B;
    state.specific_force_B = imu.specific_force_B;
    state.p_N = truth.X_NB.p;
    state.v_N = truth.v_N;
    state.R_NB = truth.X_NB.R;
    state.wind_N = truth.wind_N;
    const std::optional<std::string> state_line = ardupilot::StateLine(state);
    if (!state_line) return std::nullopt;
    line = *state_line;
    gathered = {};
    owed = false;
    Answer();

    while (const std::optional<Received> received = Next()) {
      if (received->from != socket.owner()) {
        Open(*received);
        return std::nullopt;
      }
      switch (sequence.Classify(received->packet.frame_count)) {
        case ardupilot::ServoEvent::kRepeat:
          ++counts.repeated;
          Answer();
          break;
        case ardupilot::ServoEvent::kReset:
          Open(*received);
          return std::nullopt;
        case ardupilot::ServoEvent::kNext:
          Obey(*received);
          ++counts.answers;
          return motors.Speeds(commands, parameters.thrust_curvature);
      }
    }
    return std::nullopt;
  }

  ArduPilotPhysicsParameters parameters;
  MotorMapping motors;
  asio::io_context io;
  control::SessionSocket socket{io};  // its owner is the peer
  std::atomic<bool> stop = false;
  static_assert(std::atomic<bool>::is_always_lock_free);
  PhysicsCounts counts;

  Clock::time_point heard;  // from the peer, or state_line to it
  ardupilot::ServoSequence sequence;
  bool owed = false;  // an answer to what has been obeyed: a flight that begins now owes it too
  MotorCommands commands{};
  double step_s = 0;  // asked for
  GatheredReadings gathered;
  std::string line;  // the last answer
};

ArduPilotPhysics::ArduPilotPhysics(const ArduPilotPhysicsParameters& parameters,
                                   const AirframeParameters& aircraft)
    : impl_(std::make_unique<Impl>(parameters, aircraft)) {}

ArduPilotPhysics::~ArduPilotPhysics() = default;

std::optional<double> ArduPilotPhysics::step_s() const {
  return impl_->step_s > 0 && impl_->step_s < kCoarseStep_s - 1e-6 ? kArduPilotFineStep_s : kCoarseStep_s;
}
bool ArduPilotPhysics::Begin() { return impl_->Begin(); }

std::optional<Actuation> ArduPilotPhysics::Step(double dt_s, const SensorReadings& readings,
                                                const Truth& truth) {
  return impl_->Step(dt_s, readings, truth);
}

void ArduPilotPhysics::Stop() { impl_->stop = true; }
PhysicsCounts ArduPilotPhysics::counts() const { return impl_->counts; }

std::string ArduPilotPhysics::Motors() const { return impl_->motors.order().Name(); }

std::string ArduPilotPhysics::Where() const {
  const udp::endpoint here = impl_->socket.Where();
  return fmt::format("udp://{}:{}", here.address().to_string(), here.port());
}

}  // namespace kestrel::sim
