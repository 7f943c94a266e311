// SPDX-License-Identifier: Apache-2.0
#include "control/link/afcs_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>
#include <utility>

#include "base/clock_sync.h"
#include "base/diagnostics.h"
#include "base/stopwatch.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

constexpr std::chrono::milliseconds kAfcsTick{5};

udp::endpoint Resolve(asio::io_context& io, const AfcsLinkOptions& options) {
  error_code error;
  udp::resolver resolver(io);
  const auto found = resolver.resolve(options.host, std::to_string(options.port), error);
  if (error || found.empty())
    throw InputError("AFCS", fmt::format("host {}: {}", options.host, error ? error.message() : "not known"));
  return found.begin()->endpoint();
}

wire::AfcsMessage MessageFor(const Setpoint& setpoint, const wire::AfcsSettings& afcs) {
  if (const auto* velocity = std::get_if<VelocitySetpoint>(&setpoint))
    return wire::TeleopFor(*velocity, afcs.teleop);
  const auto& place = std::get<PositionSetpoint>(setpoint);
  return wire::AfcsFlyTo{.pos_mode = static_cast<std::int16_t>(afcs.fly_to_position),
                         .hdg_mode = static_cast<std::int16_t>(afcs.fly_to_heading),
                         .transit_time = 0,
                         .x = place.p_N.x(),
                         .y = place.p_N.y(),
                         .z = place.p_N.z(),
                         .hdg = place.yaw};
}

VehicleState StateOf(const wire::AfcsState& s) {
  VehicleState state;
  state.p_NB = {s.x, s.y, s.z};
  state.v_N = {s.vx, s.vy, s.vz};
  state.R_NB = RotationFromTaitBryan({.yaw = s.psi, .pitch = s.theta, .roll = s.phi});
  state.w_B = {s.p, s.q, s.r};
  state.R_NB_inertial = state.R_NB;
  return state;
}

}  // namespace

// All of it but the thread itself is under the mutex, the sending too: after Silence() nothing goes out.
struct AfcsLink::Session {
  explicit Session(const AfcsLinkOptions& o)
      : options(o),
        profile(wire::ProfileOf(o.afcs)),
        codec(profile),
        receiver(codec),
        peer(Resolve(io, o)),
        where(fmt::format("AFCS at {}:{}", o.host, o.port)),
        begun_s(MonotonicNow_s()) {
    Tick();
    thread = std::thread([this] { io.run(); });
  }
  ~Session() {
    asio::post(io, [this] {
      const std::lock_guard lock(mutex);
      if (open) Transmit(wire::AfcsClose{}, MonotonicNow_s());
      io.stop();
    });
    thread.join();
  }

  // --------------------------------------------------------------------------------- on the thread

  void Tick() {
    {
      const std::lock_guard lock(mutex);
      const double now_s = MonotonicNow_s();
      if (open && now_s - heard_s > options.silent_s) Reopen("fell silent");
      if (!socket.is_open()) Connect();
      if (now_s >= open_due_s) {
        Transmit(wire::AfcsOpen{}, now_s);
        open_due_s = now_s + (open ? options.alive_s : options.open_s);
      }
      SendDue(now_s);
      if (open && platform_wanted && now_s >= platform_due_s) {
        Transmit(*platform_wanted, now_s);
        platform_due_s = now_s + 1 / options.platform_hz;
      }
      Listen();
    }
    timer.expires_after(kAfcsTick);
    timer.async_wait([this](const error_code& error) {
      if (!error) Tick();
    });
  }

  // The route to it may not be there yet, or no more: then again at the next tick.
  void Connect() {
    error_code error;
    socket.open(peer.protocol(), error);
    if (!error) socket.connect(peer, error);
    if (!error) socket.non_blocking(true, error);
    no_way = error ? error.message() : "";
    if (error) socket.close(error);
  }

  void Listen() {
    if (listening || !socket.is_open()) return;
    listening = true;
    socket.async_receive(asio::buffer(buffer), [this](const error_code& error, std::size_t size) {
      const std::lock_guard lock(mutex);
      listening = false;
      // Refused: nobody is there yet. What lasts is seen by sending; the next tick listens again.
      if (error) return;
      Receive({buffer.data(), size});
      Listen();
    });
  }

  void Reopen(const char* reason) {
    open = false;
    why_not_open = reason;
    open_due_s = 0;
    receiver.Reset();  // the clock of what answers now may be another
  }

  void Receive(std::span<const std::uint8_t> bytes) {
    const auto datagram = receiver.Receive(bytes);
    if (!datagram) return;
    const double now_s = MonotonicNow_s();
    const auto* ack = std::get_if<wire::AfcsAck>(&datagram->message);
    if (ack) {
      if (!open && Acknowledges(*ack)) {
        open = true;
        heard_s = now_s;
        open_due_s = now_s + options.alive_s;
        receiver.Reset();  // stragglers of an earlier session do not count
        sync = {};
        SendDue(now_s);
      }
      ++received;
      return;
    }
    if (!open) return;
    ++received;
    if (const auto* state_message = std::get_if<wire::AfcsState>(&datagram->message))
      HearState(*state_message, wire::Seconds(datagram->time), now_s);
    else if (const auto* gps_message = std::get_if<wire::AfcsGpsState>(&datagram->message))
      gps = *gps_message;
    else if (const auto* platform_message = std::get_if<wire::AfcsPlatform>(&datagram->message))
      platform = *platform_message;
    else if (const auto* place = std::get_if<wire::AfcsDesiredPosition>(&datagram->message)) {
      desired = PositionSetpoint{{place->n, place->e, place->d}, place->hdg};
      unanswered_since_s.reset();
    } else if (std::holds_alternative<wire::AfcsClose>(datagram->message)) {
      Reopen("closed the session");
    }
  }

  // An early server's acknowledgement says of what, or has no such field.
  bool Acknowledges(const wire::AfcsAck& ack) const {
    const auto layout = [this](const char* name) {
      return std::find_if(profile.messages.begin(), profile.messages.end(),
                          [&](const auto& m) { return m.name == name; });
    };
    return layout("ack")->fields.empty() ||
           ack.acknowledged == static_cast<std::uint32_t>(layout("open")->id);
  }

  void HearState(const wire::AfcsState& message, double their_s, double now_s) {
    VehicleState next = StateOf(message);
    sync.AddSample(their_s, now_s);
    next.t_s = sync.ToOurs(their_s).value_or(now_s);
    next.landed = message.rpm0 < options.afcs.stopped_rpm;
    heard_s = now_s;
    if (!Sane(next)) {
      --received;
      ++not_sane;
      not_sane_s = now_s;
      return;
    }
    state = next;
    state_s = now_s;
  }

  void SendDue(double now_s) {
    if (!open || !setpoint || now_s < setpoint_due_s || now_s - setpoint_s > kRepeat_s) return;
    if (!Transmit(MessageFor(*setpoint, options.afcs), now_s)) return;
    ++sent;
    setpoint_due_s = now_s + 1 / options.repeat_hz;
    if (!std::holds_alternative<PositionSetpoint>(*setpoint))
      unanswered_since_s.reset();
    else if (!unanswered_since_s)
      unanswered_since_s = now_s;
  }

  bool Transmit(const wire::AfcsMessage& message, double now_s) {
    if (!socket.is_open()) return false;
    last_sent = wire::After(last_sent, wire::AfcsTimeOf(now_s));
    error_code error;
    socket.send(asio::buffer(codec.Encode({last_sent, message})), 0, error);
    // What is refused was an earlier one, to a far end that was not there: this one may arrive.
    if (error == asio::error::connection_refused)
      socket.send(asio::buffer(codec.Encode({last_sent, message})), 0, error);
    if (!error || error == asio::error::connection_refused) return !error;
    if (error == asio::error::would_block || error == asio::error::no_buffer_space) return false;
    no_way = error.message();
    socket.close(error);
    return false;
  }

  // ------------------------------------------------------------------------------- from any thread

  void Post(const Setpoint& wanted) {
    const std::lock_guard lock(mutex);
    not_expressible = std::holds_alternative<AttitudeSetpoint>(wanted)
                          ? "AFCS has no AttitudeSetpoint: not sent"
                      : std::holds_alternative<RateSetpoint>(wanted) ? "AFCS has no RateSetpoint: not sent"
                      : !Finite(wanted)                              ? "a setpoint was not finite: not sent"
                                                                     : "";
    if (!not_expressible.empty()) return setpoint.reset();  // nor what was asked for before
    setpoint = wanted;
    setpoint_s = MonotonicNow_s();
    setpoint_due_s = 0;
    asio::post(io, [this] {
      const std::lock_guard inner(mutex);
      SendDue(MonotonicNow_s());
    });
  }

  void Command(const wire::AfcsPlatform& wanted) {
    const std::lock_guard lock(mutex);
    platform_wanted = wanted;
    platform_due_s = 0;  // at the next tick
  }

  FlightMode Mode() const {
    if (state.landed) return FlightMode::kStopped;
    if (!setpoint || MonotonicNow_s() - setpoint_s > kRepeat_s) return FlightMode::kHold;
    return std::holds_alternative<VelocitySetpoint>(*setpoint) ? FlightMode::kVelocity
                                                               : FlightMode::kPosition;
  }

  std::string Error() const {
    const double now_s = MonotonicNow_s();
    if (!no_way.empty()) return fmt::format("{}: {}", where, no_way);
    if (!open && !why_not_open.empty())
      return fmt::format("{} {}, and is being opened again", where, why_not_open);
    if (!open && now_s - begun_s > options.open_s) return fmt::format("{} does not answer", where);
    if (!not_expressible.empty()) return not_expressible;
    if (not_sane > 0 && now_s - not_sane_s < options.silent_s)
      return fmt::format("{} sent a state that cannot be", where);
    if (unanswered_since_s && now_s - *unanswered_since_s > options.silent_s)
      return fmt::format("{} does not confirm where it is to fly to", where);
    return "";
  }

  const AfcsLinkOptions options;
  const wire::AfcsProfile profile;
  const wire::AfcsCodec codec;
  mutable std::mutex mutex;
  wire::AfcsReceiver receiver;
  asio::io_context io;
  udp::socket socket{io};
  asio::steady_timer timer{io};
  const udp::endpoint peer;
  const std::string where;
  std::array<std::uint8_t, 65536> buffer{};
  bool listening = false;

  bool open = false;
  const double begun_s;
  double heard_s = 0;  // a state, or the beginning of the session
  double open_due_s = 0;
  std::string no_way, why_not_open, not_expressible;
  wire::AfcsTime last_sent;
  ClockSync sync;

  VehicleState state;
  std::optional<double> state_s;
  std::optional<wire::AfcsGpsState> gps;
  std::optional<wire::AfcsPlatform> platform, platform_wanted;
  double platform_due_s = 0;
  std::optional<PositionSetpoint> desired;
  std::optional<Setpoint> setpoint;
  double setpoint_s = 0, setpoint_due_s = 0;
  std::optional<double> unanswered_since_s;  // the first FLY_TO that no answer followed
  std::uint64_t received = 0, sent = 0, not_sane = 0;
  double not_sane_s = 0;

  std::thread thread;
};

AfcsLink::AfcsLink(const AfcsLinkOptions& options) : session_(std::make_unique<Session>(options)) {}
AfcsLink::~AfcsLink() = default;

VehicleState AfcsLink::State() const {
  const std::lock_guard lock(session_->mutex);
  VehicleState state = session_->state;
  if (session_->state_s) state.mode = session_->Mode();
  return state;
}

void AfcsLink::Send(const Setpoint& setpoint) { session_->Post(setpoint); }

void AfcsLink::Aid(const AttitudeAid&) {
  const std::lock_guard lock(session_->mutex);
  session_->not_expressible = "AFCS has no AttitudeAid: not sent";
}

LinkHealth AfcsLink::Health() const {
  const std::lock_guard lock(session_->mutex);
  const Session& s = *session_;
  LinkHealth health;
  health.open = s.open;
  if (s.state_s) health.state_age_s = MonotonicNow_s() - *s.state_s;
  health.received = s.received;
  health.refused = s.not_sane;
  for (std::size_t why = 0; why < wire::kAfcsRefusals; ++why)
    health.refused += s.receiver.refused(static_cast<wire::AfcsRefusal>(why));
  health.sent = s.sent;
  health.error = s.Error();
  return health;
}

void AfcsLink::Silence() {
  const std::lock_guard lock(session_->mutex);
  session_->setpoint.reset();
}

void AfcsLink::Point(double roll, double pitch, double yaw) {
  session_->Command({.mode = static_cast<std::int16_t>(session_->options.afcs.platform_relative),
                     .relative_roll = roll,
                     .relative_pitch = pitch,
                     .relative_yaw = yaw});
}
void AfcsLink::PointAbsolute(double roll, double pitch, double yaw) {
  session_->Command({.mode = static_cast<std::int16_t>(session_->options.afcs.platform_absolute),
                     .absolute_roll = roll,
                     .absolute_pitch = pitch,
                     .absolute_yaw = yaw});
}
void AfcsLink::PointAt(const Eigen::Vector3d& p_N) {
  session_->Command({.mode = static_cast<std::int16_t>(session_->options.afcs.platform_point),
                     .camera_n = p_N.x(),
                     .camera_e = p_N.y(),
                     .camera_d = p_N.z()});
}

std::optional<wire::AfcsPlatform> AfcsLink::Platform() const {
  const std::lock_guard lock(session_->mutex);
  return session_->platform;
}
std::optional<PositionSetpoint> AfcsLink::Desired() const {
  const std::lock_guard lock(session_->mutex);
  return session_->desired;
}
std::optional<wire::AfcsGpsState> AfcsLink::Gps() const {
  const std::lock_guard lock(session_->mutex);
  return session_->gps;
}

}  // namespace kestrel::control
