// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/ardupilot_physics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <deque>
#include <span>
#include <string>

#include "sim/server/physics/ardupilot_json.h"
#include "sim/server/physics/gathered_readings.h"
#include "sim/server/physics/io_wait.h"
#include "sim/server/physics/motor_layout.h"

namespace kestrel {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using Clock = std::chrono::steady_clock;

constexpr double kLongest_s = 0.1;  // steps of this and more do not count for ArduPilot
// More than these are waiting: nobody reads them, and the oldest are of no use.
constexpr std::size_t kWaiting = 64;

}  // namespace

struct ArduPilotPhysics::Impl {
  struct Received {
    udp::endpoint from;
    Clock::time_point at;
    wire::ServoPacket packet;
  };

  Impl(const ArduPilotPhysicsParameters& p, const AirframeParameters& aircraft)
      : parameters(p), motors(p.layout, aircraft), socket(io) {
    const udp::endpoint here(ParseAddress(p.address), static_cast<std::uint16_t>(p.port));
    Listen("udp", here, [&] {
      socket.open(here.protocol());
      socket.bind(here);
    });
    Read();
  }

  void Read() {
    socket.async_receive_from(asio::buffer(buffer), sender,
                              [this](const boost::system::error_code& error, std::size_t size) {
                                if (error == asio::error::operation_aborted) return;
                                if (!error) Take(size);
                                Read();
                              });
  }

  void Take(std::size_t size) {
    const auto packet = wire::DecodeServoPacket(std::span(buffer).first(size));
    if (!packet) {
      ++counts.refused;
      return;
    }
    if (waiting.size() == kWaiting) waiting.pop_front();
    waiting.push_back({sender, Clock::now(), *packet});
  }

  // The next packet; none: Stop().
  std::optional<Received> Next() {
    if (!wait.Until([&] { return !waiting.empty(); }) || wait.stopped()) return std::nullopt;
    const Received received = waiting.front();
    waiting.pop_front();
    return received;
  }

  void Open(const Received& first) {
    peer = first.from;
    sequence = {};
    sequence.Take(first.packet.frame_count);
    Obey(first);
  }

  void Obey(const Received& received) {
    heard = received.at;
    owed = true;
    const wire::ServoPacket& packet = received.packet;
    const double range_us = parameters.pwm_max_us - parameters.pwm_min_us;
    for (std::size_t i = 0; i < commands.size(); ++i)
      commands[i] = (packet.pwm_us[i] - parameters.pwm_min_us) / range_us;
    step_s = packet.frame_rate_hz > 0 ? 1.0 / packet.frame_rate_hz : 0;
  }

  bool Begin() {
    if (wait.stopped()) return false;
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
    boost::system::error_code ignored;  // a lost one is asked for again
    socket.send_to(asio::buffer(line), peer, 0, ignored);
  }

  std::optional<Actuation> Step(double dt_s, const SensorReadings& readings, const Truth& truth) {
    gathered.Add(readings);
    const double most = std::max(1.0, std::ceil(kLongest_s / dt_s - 1e-6) - 1);
    const double steps = std::clamp(std::round(step_s / dt_s), 1.0, most);
    if (gathered.steps() < steps) return motors.Speeds(commands, parameters.thrust_curvature);

    wire::PhysicsState state;
    state.t_s = truth.t_s;
    const ImuSample imu = gathered.MeanImu();
    const Eigen::Quaterniond R_AB = motors.R_BA().conjugate();
    state.w_B = R_AB * imu.w_B;
    state.specific_force_B = R_AB * imu.specific_force_B;
    state.p_N = truth.X_NB.p;
    state.v_N = truth.v_N;
    state.R_NB = truth.X_NB.R * motors.R_BA();
    state.wind_N = truth.wind_N;
    const std::optional<std::string> said = wire::StateLine(state);
    if (!said) return std::nullopt;
    line = *said;
    gathered = {};
    owed = false;
    Answer();

    while (const std::optional<Received> received = Next()) {
      if (received->from != peer) {
        if (received->at - heard < std::chrono::duration<double>(parameters.gone_s)) {
          ++counts.refused;
          continue;
        }
        Open(*received);
        return std::nullopt;
      }
      switch (sequence.Take(received->packet.frame_count)) {
        case wire::ServoEvent::kRepeat:
          heard = received->at;
          ++counts.repeated;
          Answer();
          break;
        case wire::ServoEvent::kReset:
          Open(*received);
          return std::nullopt;
        case wire::ServoEvent::kNext:
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
  IoWait wait{io};
  udp::socket socket;
  std::array<std::uint8_t, 2048> buffer{};
  udp::endpoint sender;  // of what is in it
  std::deque<Received> waiting;
  PhysicsCounts counts;

  udp::endpoint peer;
  Clock::time_point heard;  // from it
  wire::ServoSequence sequence;
  bool owed = false;  // an answer to what has been obeyed: a flight that begins now owes it too
  std::array<double, 4> commands{};
  double step_s = 0;  // asked for
  GatheredReadings gathered;
  std::string line;  // the last answer
};

ArduPilotPhysics::ArduPilotPhysics(const ArduPilotPhysicsParameters& parameters,
                                   const AirframeParameters& aircraft)
    : impl_(std::make_unique<Impl>(parameters, aircraft)) {}

ArduPilotPhysics::~ArduPilotPhysics() = default;

bool ArduPilotPhysics::Begin() { return impl_->Begin(); }

std::optional<Actuation> ArduPilotPhysics::Step(double dt_s, const SensorReadings& readings,
                                                const Truth& truth) {
  return impl_->Step(dt_s, readings, truth);
}

void ArduPilotPhysics::Stop() { impl_->wait.Stop(); }
PhysicsCounts ArduPilotPhysics::counts() const { return impl_->counts; }

std::string ArduPilotPhysics::Where() const {
  const udp::endpoint here = impl_->socket.local_endpoint();
  return fmt::format("udp://{}:{}", here.address().to_string(), here.port());
}

}  // namespace kestrel
