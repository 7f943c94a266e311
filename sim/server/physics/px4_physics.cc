// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/px4_physics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "control/wire/mavlink_messages.h"
#include "sim/server/physics/io_wait.h"
#include "sim/server/physics/motor_layout.h"

namespace kestrel::sim {
namespace {

namespace asio = boost::asio;
namespace mav = control::wire::mavlink;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::uint8_t kSystem = 1, kComponent = 200;  // as PX4's own simulators have it
constexpr std::uint64_t kLockstepFlag = 1;
constexpr std::uint8_t kArmed = 128;
constexpr std::uint16_t kSetMessageInterval = 511;
// Who connects and has said nothing that MAVLink knows after this is sent away.
constexpr double kIntroduction_s = 5;
constexpr std::size_t kCandidates = 8;      // who may be silent at once; of more, the oldest goes
constexpr std::uint64_t kStrayBytes = 280;  // a whole frame's
// Further behind the real time than this, it is not caught up with.
constexpr double kBehind_s = 0.1;

Clock::duration Seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

// One that PX4 opened. Handlers that come after its end find it still there, and over.
struct Connection {
  explicit Connection(tcp::socket s) : socket(std::move(s)) {}
  tcp::socket socket;
  std::array<std::uint8_t, 2048> buffer{};
  mav::Parser parser{mav::Formats()};
  mav::Sender sender{kSystem, kComponent};
  Clock::time_point since = Clock::now();
  std::vector<mav::Message> first;  // until the session is its own
  bool over = false;
};

}  // namespace

struct Px4Physics::Impl {
  Impl(const Px4PhysicsParameters& p, const AirframeParameters& aircraft)
      : parameters(p), motors(Px4MotorOrder(MultirotorOf(aircraft)), MultirotorOf(aircraft)), acceptor(io) {
    const tcp::endpoint here(ParseAddress(p.address), static_cast<std::uint16_t>(p.port));
    Listen("tcp", here, [&] {
      acceptor.open(here.protocol());
      acceptor.set_option(tcp::acceptor::reuse_address(true));
      acceptor.bind(here);
      acceptor.listen();
    });
  }

  // Accepting and reading.

  void Accept() {
    if (accepting) return;
    accepting = true;
    acceptor.async_accept([this](const boost::system::error_code& error, tcp::socket socket) {
      accepting = false;
      if (error) {
        broken = error != asio::error::connection_aborted && error != asio::error::operation_aborted;
        return;
      }
      boost::system::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      if (candidates.size() == kCandidates) {
        Refuse(*candidates.front());
        candidates.erase(candidates.begin());
      }
      candidates.push_back(std::make_shared<Connection>(std::move(socket)));
      Read(candidates.back());
      if (introducing) Accept();
    });
  }

  void Count(const Connection& over) {
    const mav::Counts& c = over.parser.counts();
    refused += c.bad_checksum + c.bad_flags + c.bad_length + c.unconfirmed + c.unknown;
    stray_bytes += c.stray_bytes;
  }

  void Refuse(Connection& c) {
    boost::system::error_code ignored;
    c.over = true;
    c.socket.close(ignored);
    Count(c);
    ++refused;
  }

  void Read(const std::shared_ptr<Connection>& c) {
    c->socket.async_read_some(asio::buffer(c->buffer),
                              [this, c](const boost::system::error_code& error, std::size_t size) {
                                c->over = c->over || error;
                                if (c->over) return;
                                for (const mav::Frame& frame : c->parser.Stream({c->buffer.data(), size})) {
                                  const auto message = mav::Decode(frame);
                                  if (!message) continue;
                                  if (c == connection)
                                    Handle(*message);
                                  else
                                    c->first.push_back(*message);
                                }
                                // Who has said who it is, is read on when the session is its own.
                                if (c == connection || c->parser.counts().frames == 0) Read(c);
                              });
  }

  void Handle(const mav::Message& message) {
    if (const auto* controls = std::get_if<mav::HilActuatorControls>(&message)) {
      if (last_usec == controls->time_usec) {
        ++counts.repeated;
        return;
      }
      last_usec = controls->time_usec;
      lockstep = (controls->flags & kLockstepFlag) != 0;
      answered = true;
      ++counts.answers;
      for (std::size_t i = 0; i < motors.order().rotor.size(); ++i)
        commands[i] = (controls->mode & kArmed) != 0 ? static_cast<double>(controls->controls[i]) : 0;
    } else if (const auto* command = std::get_if<mav::CommandLong>(&message)) {
      if (command->command == kSetMessageInterval &&
          command->param1 == static_cast<float>(mav::HilStateQuaternion::kId)) {
        const float us = command->param2;  // 0: as a matter of course, -1: not at all
        state_period_s = us > 0 ? static_cast<double>(us) * 1e-6 : us == 0 ? 0 : -1;
      }
    }
  }

  bool Open() const { return connection && !connection->over; }

  void Close() {
    if (!connection) return;
    Count(*connection);
    boost::system::error_code ignored;
    connection->over = true;
    connection->socket.close(ignored);
    connection.reset();
  }

  // Waits until a peer has said who it is: the first that does has the session, and who is silent keeps
  // nobody waiting.
  bool Introduced() {
    Close();
    introducing = true;
    Accept();
    std::shared_ptr<Connection> introduced;
    wait.Until([&] {
      std::erase_if(candidates, [&](const auto& c) {
        const mav::Counts& heard = c->parser.counts();
        if (!introduced && heard.frames > 0 && !c->over) introduced = c;
        if (c == introduced) return true;
        const bool goes = c->over || heard.frames > 0 || heard.stray_bytes >= kStrayBytes ||
                          Clock::now() - c->since > Seconds(kIntroduction_s);
        if (goes) Refuse(*c);
        return goes;
      });
      return introduced || broken;
    });
    // Who comes during the flight waits for its end.
    introducing = false;
    boost::system::error_code ignored;
    acceptor.cancel(ignored);
    io.poll();
    for (const auto& c : candidates) Refuse(*c);
    candidates.clear();
    if (!introduced || broken || wait.stopped()) return false;
    connection = introduced;
    for (const mav::Message& message : std::exchange(connection->first, {})) Handle(message);
    Read(connection);
    return true;
  }

  bool Send(const control::wire::Bytes& bytes) {
    bool done = false;
    const auto c = connection;
    asio::async_write(c->socket, asio::buffer(bytes),
                      [&done, c](const boost::system::error_code& error, std::size_t) {
                        done = true;
                        c->over = c->over || error;
                      });
    if (wait.Until([&] { return done; })) return !c->over;
    // bytes and done are the handler's until it has run.
    boost::system::error_code ignored;
    c->socket.close(ignored);
    c->over = true;
    while (!done) io.run_one();
    return false;
  }

  // When the message of this time may go out.
  void Pace(double t_s) {
    if (parameters.speed <= 0) return;
    const Clock::time_point due = paced_from + Seconds((t_s - paced_from_s) / parameters.speed);
    if (Clock::now() > due + Seconds(kBehind_s)) {
      paced_from = Clock::now();
      paced_from_s = t_s;
      return;
    }
    wait.Until([&] { return !Open(); }, due);
  }

  std::optional<Actuation> Step(double dt_s, const SensorReadings& readings, const Truth& truth) {
    gathered.Add(readings);
    if (truth.t_s < due_s - dt_s / 2) return motors.Speeds(commands, parameters.thrust_curvature);
    if (!connection || wait.stopped()) return std::nullopt;
    due_s += parameters.sensor_period_s;

    const auto time_usec = static_cast<std::uint64_t>(std::llround(truth.t_s * 1e6));
    control::wire::Bytes bytes;
    const auto add = [&](const mav::Message& message) {
      const control::wire::Bytes frame = connection->sender.Encode(message);
      bytes.insert(bytes.end(), frame.begin(), frame.end());
    };
    if (gathered.gps) add(ToHilGps(time_usec, *gathered.gps, parameters.origin));
    if (state_period_s >= 0 && truth.t_s >= state_due_s - parameters.sensor_period_s / 2) {
      state_due_s = std::max(state_due_s + state_period_s, truth.t_s);
      add(ToHilState(time_usec, truth, gathered.MeanImu().specific_force_B, parameters.origin));
    }
    // Last, for it is what PX4 answers.
    add(ToHilSensor(time_usec, gathered, slow, parameters.origin));
    gathered = {};

    Pace(truth.t_s);
    io.poll();  // what came until now is no answer to what is about to be sent
    answered = false;
    if (!Open() || !Send(bytes)) return std::nullopt;
    const double period_s = parameters.sensor_period_s / (parameters.speed > 0 ? parameters.speed : 1);
    const Clock::time_point free = Clock::now() + Seconds(period_s);
    for (;;) {
      if (answered && lockstep) break;  // be it its last word
      if (!Open()) return std::nullopt;
      const bool in_step = lockstep;
      const auto news = [&] { return !Open() || (answered && lockstep) || lockstep != in_step; };
      const bool heard = in_step ? wait.Until(news) : wait.Until(news, free);
      if (wait.stopped()) return std::nullopt;
      if (!heard) break;  // not in lockstep: its time is up
    }
    return motors.Speeds(commands, parameters.thrust_curvature);
  }

  Px4PhysicsParameters parameters;
  MotorMapping motors;
  asio::io_context io;
  IoWait wait{io};
  tcp::acceptor acceptor;
  bool introducing = false, accepting = false, broken = false;
  std::vector<std::shared_ptr<Connection>> candidates;  // who have connected and said nothing yet
  std::shared_ptr<Connection> connection;
  PhysicsCounts counts;
  std::uint64_t refused = 0, stray_bytes = 0;  // of connections that are over

  // Of the flight.
  std::optional<std::uint64_t> last_usec;
  bool lockstep = false, answered = false;
  MotorCommands commands{};
  double state_period_s = -1, state_due_s = 0, due_s = 0;
  GatheredReadings gathered;
  SlowSensors slow;
  Clock::time_point paced_from;
  double paced_from_s = 0;
};

Px4Physics::Px4Physics(const Px4PhysicsParameters& parameters, const AirframeParameters& aircraft)
    : impl_(std::make_unique<Impl>(parameters, aircraft)) {}

Px4Physics::~Px4Physics() = default;

bool Px4Physics::Begin() {
  Impl& i = *impl_;
  i.state_period_s = -1;
  i.last_usec.reset();
  i.lockstep = i.answered = false;
  i.commands = {};
  if (!i.Introduced()) return false;
  i.state_due_s = 0;
  i.due_s = i.parameters.sensor_period_s;
  i.gathered = {};
  i.slow = {};
  i.paced_from = Clock::now();
  i.paced_from_s = 0;
  ++i.counts.flights;
  return true;
}

std::optional<Actuation> Px4Physics::Step(double dt_s, const SensorReadings& readings, const Truth& truth) {
  return impl_->Step(dt_s, readings, truth);
}

void Px4Physics::Stop() { impl_->wait.Stop(); }
bool Px4Physics::lockstep() const { return impl_->lockstep; }

std::string Px4Physics::Motors() const { return impl_->motors.order().Name(); }

std::string Px4Physics::Where() const {
  const tcp::endpoint here = impl_->acceptor.local_endpoint();
  return fmt::format("tcp://{}:{}", here.address().to_string(), here.port());
}

PhysicsCounts Px4Physics::counts() const {
  PhysicsCounts counts = impl_->counts;
  counts.refused = impl_->refused;
  counts.stray_bytes = impl_->stray_bytes;
  if (impl_->connection) {
    const mav::Counts& c = impl_->connection->parser.counts();
    counts.refused += c.bad_checksum + c.bad_flags + c.bad_length + c.unconfirmed + c.unknown;
    counts.stray_bytes += c.stray_bytes;
  }
  return counts;
}

}  // namespace kestrel::sim
