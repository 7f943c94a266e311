// SPDX-License-Identifier: Apache-2.0
#include "sim/server/afcs_server.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "control/link/session_socket.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

constexpr double kMax = 1e6;            // of any number of a setpoint
constexpr int kDatagramsAtOnce = 200;   // a flood does not keep Serve from returning
constexpr std::int16_t kFixedIn3D = 3;  // GPS
constexpr double kMinimumFall = 1e-3;   // of the camera's axis, for a place on the ground

udp::endpoint EndpointOf(const AfcsServerOptions& options) {
  error_code error;
  const auto address = asio::ip::make_address(options.address, error);
  if (error) throw InputError("AFCS server", fmt::format("address {}: {}", options.address, error.message()));
  return {address, static_cast<std::uint16_t>(options.port)};
}

std::string AfcsText(const udp::endpoint& peer) {
  return fmt::format("{}:{}", peer.address().to_string(), peer.port());
}

const char* AfcsText(control::wire::AfcsRefusal why) {
  switch (why) {
    case control::wire::AfcsRefusal::kShort:
      return "shorter than a header";
    case control::wire::AfcsRefusal::kTime:
      return "a time that is none";
    case control::wire::AfcsRefusal::kType:
    case control::wire::AfcsRefusal::kUnknown:
      return "of no known type";
    case control::wire::AfcsRefusal::kLength:
      return "not of the length of its type";
    case control::wire::AfcsRefusal::kRange:
      return "a number out of its range";
    case control::wire::AfcsRefusal::kDuplicate:
      return "the time of one that came before";
    case control::wire::AfcsRefusal::kOld:
      return "older than one that came before";
  }
  return "?";
}

bool Possible(std::initializer_list<double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::abs(x) <= kMax; });
}

}  // namespace

struct AfcsServer::Session {
  Session(const AfcsServerOptions& o, PanTilt* camera)
      : options(o),
        profile(control::wire::ProfileOf(o.afcs)),
        open_id(static_cast<std::uint32_t>(std::find_if(profile.messages.begin(), profile.messages.end(),
                                                        [](const auto& m) { return m.name == "open"; })
                                               ->id)),
        codec(profile),
        receiver(codec),
        platform(camera) {
    const udp::endpoint endpoint = EndpointOf(o);
    error_code error;
    socket.Open(endpoint, error);
    if (error)
      throw InputError("AFCS server", fmt::format("udp://{}:{}: {}", o.address, o.port, error.message()));
  }

  void Serve(double now, control::Autopilot& aircraft) {
    now_s = now;
    t_s = aircraft.State().t_s;
    Listen(aircraft);
    if (!socket.owner()) return;
    const bool state_due = Due(state_due_s, options.state_hz), gps_due = Due(gps_due_s, options.gps_hz);
    if (!state_due && !gps_due) return;
    const control::VehicleState state = aircraft.State();
    t_s = state.t_s;
    if (state_due) Transmit(StateMessage(state));
    if (gps_due) Transmit(GpsMessage(state));
  }

  // What was missed is not made up for.
  bool Due(double& due_s, double rate_hz) const {
    if (now_s < due_s) return false;
    due_s += 1 / rate_hz;
    if (due_s <= now_s) due_s = now_s + 1 / rate_hz;
    return true;
  }

  void Listen(control::Autopilot& aircraft) {
    const auto receive = [&](const std::optional<control::SessionSocket::Datagram>& datagram) {
      if (datagram) Receive(datagram->bytes, datagram->from, aircraft);
      return datagram.has_value();
    };
    const auto receive_from_owner = [&] {
      for (int i = 0; i < kDatagramsAtOnce && receive(socket.FromOwner()); ++i) continue;
    };
    receive_from_owner();
    // There is nothing more of it: it is known whether it has been silent.
    if (socket.owner() && now_s - heard_s > options.session_s) socket.Release();
    for (int i = 0; i < kDatagramsAtOnce && receive(socket.FromOthers()); ++i) receive_from_owner();
  }

  void Receive(std::span<const std::uint8_t> bytes, const udp::endpoint& peer, control::Autopilot& aircraft) {
    const std::optional<udp::endpoint>& owner = socket.owner();
    if (peer != owner) {
      const auto decoded = codec.Decode(bytes);
      if (const auto* why = std::get_if<control::wire::AfcsRefusal>(&decoded))
        return counts.CountIgnored(ignored::kDamaged,
                                   fmt::format("{}, from {}", AfcsText(*why), AfcsText(peer)));
      const bool opens = std::holds_alternative<control::wire::AfcsOpen>(
          std::get<control::wire::AfcsDatagram>(decoded).message);
      if (owner || !opens)
        return counts.CountIgnored(
            opens ? ignored::kSecondClient : ignored::kNoSession,
            AfcsText(peer) + (owner ? "; it is that of " + AfcsText(*owner) : "; nobody has opened one"));
      socket.Own(peer);
      receiver.Reset();
      state_due_s = gps_due_s = now_s;
    }
    const auto datagram = receiver.Receive(bytes);
    if (!datagram) return CountRefusal();
    heard_s = now_s;
    std::visit([&](const auto& message) { Obey(message, aircraft); }, datagram->message);
  }

  void CountRefusal() {
    for (std::size_t i = 0; i < control::wire::kAfcsRefusals; ++i) {
      const auto why = static_cast<control::wire::AfcsRefusal>(i);
      const bool again =
          why == control::wire::AfcsRefusal::kDuplicate || why == control::wire::AfcsRefusal::kOld;
      const std::uint64_t count = receiver.refused(why);
      counts.CountIgnored(again ? ignored::kAgain : ignored::kDamaged, AfcsText(why), count - refused[i]);
      refused[i] = count;
    }
  }

  // Whether a setpoint of these numbers is to be followed.
  bool Follows(const char* name, std::initializer_list<double> numbers) {
    if (!Possible(numbers)) {
      ++counts.refused;
      counts.CountIgnored(ignored::kImpossible, fmt::format("{} {}", name, fmt::join(numbers, " ")));
      return false;
    }
    ++counts.setpoints;
    if (pilot_allows)
      ++counts.followed;
    else
      counts.CountIgnored(ignored::kPilot, name);
    return pilot_allows;
  }

  void Obey(const control::wire::AfcsOpen&, control::Autopilot&) {
    Transmit(control::wire::AfcsAck{open_id});
  }
  void Obey(const control::wire::AfcsClose&, control::Autopilot&) {
    Transmit(control::wire::AfcsClose{});
    socket.Release();
  }
  void Obey(const control::wire::AfcsTeleop& m, control::Autopilot& aircraft) {
    if (!Follows("TELEOP", {m.fore, m.side, m.alt, m.hdg})) return;
    aircraft.Send(control::wire::VelocityOf(m, options.afcs.teleop));
  }
  void Obey(const control::wire::AfcsFlyTo& m, control::Autopilot& aircraft) {
    if (m.pos_mode != options.afcs.fly_to_position || m.hdg_mode != options.afcs.fly_to_heading) {
      ++counts.refused;
      return counts.CountIgnored(ignored::kImpossible,
                                 fmt::format("FLY_TO with the modes {} and {}", m.pos_mode, m.hdg_mode));
    }
    if (!Follows("FLY_TO", {m.x, m.y, m.z, m.hdg})) return;
    aircraft.Send(control::PositionSetpoint{{m.x, m.y, m.z}, m.hdg});
    Transmit(control::wire::AfcsDesiredPosition{m.x, m.y, m.z, m.hdg});
  }
  void Obey(const control::wire::AfcsPlatform& m, control::Autopilot& aircraft) {
    if (!platform) return;
    if (m.mode == options.afcs.platform_relative && Possible({m.relative_yaw, m.relative_pitch}))
      platform->Turn(LookFromAircraft{m.relative_yaw, m.relative_pitch});
    else if (m.mode == options.afcs.platform_absolute && Possible({m.absolute_yaw, m.absolute_pitch}))
      platform->Turn(LookInN{m.absolute_yaw, m.absolute_pitch});
    else if (m.mode == options.afcs.platform_point && Possible({m.camera_n, m.camera_e, m.camera_d}))
      platform->Turn(LookAt{{m.camera_n, m.camera_e, m.camera_d}});
    else
      return counts.CountIgnored("turns of the camera that cannot be", fmt::format("PLATFORM {}", m.mode));
    Transmit(PlatformMessage(m.mode, aircraft.State()));
  }
  template <class Other>
  void Obey(const Other&, control::Autopilot&) {}  // says what we say

  // Angles as they are now; of the camera's place, the one it was told to look at, otherwise where its axis
  // meets the ground, the level of N's origin, and none if it looks above the horizon.
  control::wire::AfcsPlatform PlatformMessage(std::int16_t mode, const control::VehicleState& state) const {
    const PanTiltAngles& angles = platform->angles();
    const Eigen::Quaterniond R_NP = state.R_NB * PlatformRotation(angles);
    const TaitBryan absolute = TaitBryanFromRotation(R_NP.toRotationMatrix());
    Eigen::Vector3d seen_N = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    const Eigen::Vector3d axis_N = R_NP * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d camera_N = state.p_NB + state.R_NB * platform->position_m();
    if (const auto* at = std::get_if<LookAt>(&platform->look()))
      seen_N = at->p_N;
    else if (axis_N.z() > kMinimumFall && camera_N.z() < 0)
      seen_N = camera_N - axis_N * (camera_N.z() / axis_N.z());
    return {.mode = mode,
            .relative_roll = 0,
            .relative_pitch = angles.tilt,
            .relative_yaw = angles.pan,
            .absolute_roll = absolute.roll,
            .absolute_pitch = absolute.pitch,
            .absolute_yaw = absolute.yaw,
            .camera_n = seen_N.x(),
            .camera_e = seen_N.y(),
            .camera_d = seen_N.z()};
  }

  control::wire::AfcsState StateMessage(const control::VehicleState& s) const {
    const TaitBryan angles = TaitBryanFromRotation(s.R_NB.toRotationMatrix());
    control::wire::AfcsState m;
    m.phi = angles.roll, m.theta = angles.pitch, m.psi = angles.yaw;
    m.p = m.raw_p = s.w_B.x(), m.q = m.raw_q = s.w_B.y(), m.r = m.raw_r = s.w_B.z();
    m.x = s.p_NB.x(), m.y = s.p_NB.y(), m.z = s.p_NB.z();
    m.vx = s.v_N.x(), m.vy = s.v_N.y(), m.vz = s.v_N.z();
    m.rpm0 = s.landed ? 0 : static_cast<std::uint16_t>(std::lround(options.rotor_rpm));
    return m;
  }

  control::wire::AfcsGpsState GpsMessage(const control::VehicleState& s) const {
    control::wire::AfcsGpsState m;
    m.numsv = static_cast<std::int16_t>(options.satellites);
    m.fixtype = kFixedIn3D;
    m.vel_n = s.v_N.x(), m.vel_e = s.v_N.y(), m.vel_d = s.v_N.z();
    m.pos_n = s.p_NB.x(), m.pos_e = s.p_NB.y(), m.pos_d = s.p_NB.z();
    m.lat = s.p_NB.x(), m.lon = s.p_NB.y(), m.alt = s.p_NB.z();
    if (options.origin) {
      const GeodeticPosition place = GeodeticOf(*options.origin, s.p_NB);
      m.lat = place.latitude_deg, m.lon = place.longitude_deg, m.alt = place.altitude_m;
    }
    return m;
  }

  // What cannot be sent is lost, as anything on UDP may be.
  void Transmit(const control::wire::AfcsMessage& message) {
    last_sent = control::wire::After(last_sent, control::wire::AfcsTimeOf(t_s));
    if (const auto& owner = socket.owner()) socket.Send(codec.Encode({last_sent, message}), *owner);
  }

  const AfcsServerOptions options;
  const control::wire::AfcsProfile profile;
  const std::uint32_t open_id;
  const control::wire::AfcsCodec codec;
  control::wire::AfcsReceiver receiver;  // of the owner
  PanTilt* platform;
  asio::io_context io;
  control::SessionSocket socket{io};

  WireCounts counts;
  std::array<std::uint64_t, control::wire::kAfcsRefusals> refused{};  // by the receiver, as far as counted
  bool pilot_allows = true;
  double now_s = 0, t_s = 0;  // ours, and the aircraft's
  double heard_s = 0, state_due_s = 0, gps_due_s = 0;
  control::wire::AfcsTime last_sent;
};

AfcsServer::AfcsServer(const AfcsServerOptions& options, PanTilt* platform)
    : session_(std::make_unique<Session>(options, platform)) {}
AfcsServer::~AfcsServer() = default;

void AfcsServer::Serve(double now_s, control::Autopilot& aircraft) { session_->Serve(now_s, aircraft); }
void AfcsServer::SetPilot(bool allows) { session_->pilot_allows = allows; }
const WireCounts& AfcsServer::Received() const { return session_->counts; }
std::string AfcsServer::Where() const {
  const udp::endpoint endpoint = session_->socket.Where();
  const std::string address = endpoint.address().to_string();
  return endpoint.address().is_v6() ? fmt::format("udp://[{}]:{}", address, endpoint.port())
                                    : fmt::format("udp://{}:{}", address, endpoint.port());
}

}  // namespace kestrel::sim
