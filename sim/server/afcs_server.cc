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

#include "base/yaml/yaml_fields.h"
#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

constexpr double kMost = 1e6;           // of any number of a setpoint
constexpr int kDatagramsAtOnce = 200;   // a flood does not keep Serve from returning
constexpr std::int16_t kFixedIn3D = 3;  // GPS
constexpr double kMinimumFall = 1e-3;   // of the camera's axis, for a place on the ground

udp::endpoint EndpointOf(const AfcsServerOptions& options) {
  error_code error;
  const auto address = asio::ip::make_address(options.address, error);
  if (error) throw InputError({fmt::format("AFCS server: address {}: {}", options.address, error.message())});
  return {address, static_cast<std::uint16_t>(options.port)};
}

std::string TextOf(const udp::endpoint& peer) {
  return fmt::format("{}:{}", peer.address().to_string(), peer.port());
}

const char* TextOf(wire::AfcsRefusal why) {
  switch (why) {
    case wire::AfcsRefusal::kShort:
      return "shorter than a header";
    case wire::AfcsRefusal::kTime:
      return "a time that is none";
    case wire::AfcsRefusal::kType:
    case wire::AfcsRefusal::kUnknown:
      return "of no known type";
    case wire::AfcsRefusal::kLength:
      return "not of the length of its type";
    case wire::AfcsRefusal::kRange:
      return "a number out of its range";
    case wire::AfcsRefusal::kDuplicate:
      return "the time of one that came before";
    case wire::AfcsRefusal::kOld:
      return "older than one that came before";
  }
  return "?";
}

bool Possible(std::initializer_list<double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::abs(x) <= kMost; });
}

}  // namespace

struct AfcsServer::Session {
  Session(const AfcsServerOptions& o, PanTilt* camera)
      : options(o),
        profile(wire::ProfileOf(o.afcs)),
        open_id(static_cast<std::uint32_t>(std::find_if(profile.messages.begin(), profile.messages.end(),
                                                        [](const auto& m) { return m.name == "open"; })
                                               ->id)),
        codec(profile),
        receiver(codec),
        platform(camera) {
    const udp::endpoint endpoint = EndpointOf(o);
    error_code error;
    socket.open(endpoint.protocol(), error);
    if (!error) socket.bind(endpoint, error);
    if (!error) socket.non_blocking(true, error);
    if (error)
      throw InputError({fmt::format("AFCS server: udp://{}:{}: {}", o.address, o.port, error.message())});
  }

  void Serve(double now, Autopilot& aircraft) {
    now_s = now;
    t_s = aircraft.State().t_s;
    Listen(aircraft);
    if (owner && now_s - heard_s > options.session_s) owner.reset();
    if (!owner) return;
    const bool state_due = Due(state_due_s, options.state_hz), gps_due = Due(gps_due_s, options.gps_hz);
    if (!state_due && !gps_due) return;
    const VehicleState state = aircraft.State();
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

  void Listen(Autopilot& aircraft) {
    for (int i = 0; i < kDatagramsAtOnce; ++i) {
      udp::endpoint peer;
      error_code error;
      const std::size_t size = socket.receive_from(asio::buffer(buffer), peer, 0, error);
      if (error == asio::error::would_block) return;
      if (error) continue;
      Hear({buffer.data(), size}, peer, aircraft);
    }
  }

  void Hear(std::span<const std::uint8_t> bytes, const udp::endpoint& peer, Autopilot& aircraft) {
    if (owner && now_s - heard_s > options.session_s) owner.reset();
    if (peer != owner) {
      const auto decoded = codec.Decode(bytes);
      if (const auto* why = std::get_if<wire::AfcsRefusal>(&decoded))
        return counts.NotHeeded(unheeded::kDamaged, fmt::format("{}, from {}", TextOf(*why), TextOf(peer)));
      const bool opens =
          std::holds_alternative<wire::AfcsOpen>(std::get<wire::AfcsDatagram>(decoded).message);
      if (owner || !opens)
        return counts.NotHeeded(
            opens ? unheeded::kSecondClient : unheeded::kNoSession,
            TextOf(peer) + (owner ? "; it is that of " + TextOf(*owner) : "; nobody has opened one"));
      owner = peer;
      receiver.Reset();
      state_due_s = gps_due_s = now_s;
    }
    const auto datagram = receiver.Receive(bytes);
    if (!datagram) return CountRefusal();
    heard_s = now_s;
    std::visit([&](const auto& message) { Obey(message, aircraft); }, datagram->message);
  }

  void CountRefusal() {
    for (std::size_t i = 0; i < wire::kAfcsRefusals; ++i) {
      const auto why = static_cast<wire::AfcsRefusal>(i);
      const bool again = why == wire::AfcsRefusal::kDuplicate || why == wire::AfcsRefusal::kOld;
      const std::uint64_t count = receiver.refused(why);
      counts.NotHeeded(again ? unheeded::kAgain : unheeded::kDamaged, TextOf(why), count - refused[i]);
      refused[i] = count;
    }
  }

  // Whether a setpoint of these numbers is to be followed.
  bool Follows(const char* name, std::initializer_list<double> numbers) {
    if (!Possible(numbers)) {
      ++counts.refused;
      counts.NotHeeded(unheeded::kImpossible, fmt::format("{} {}", name, fmt::join(numbers, " ")));
      return false;
    }
    ++counts.setpoints;
    if (pilot_allows)
      ++counts.followed;
    else
      counts.NotHeeded(unheeded::kPilot, name);
    return pilot_allows;
  }

  void Obey(const wire::AfcsOpen&, Autopilot&) { Transmit(wire::AfcsAck{open_id}); }
  void Obey(const wire::AfcsClose&, Autopilot&) {
    Transmit(wire::AfcsClose{});
    owner.reset();
  }
  void Obey(const wire::AfcsTeleop& m, Autopilot& aircraft) {
    if (!Follows("TELEOP", {m.fore, m.side, m.alt, m.hdg})) return;
    aircraft.Send(wire::VelocityOf(m, options.afcs.teleop));
  }
  void Obey(const wire::AfcsFlyTo& m, Autopilot& aircraft) {
    if (m.pos_mode != options.afcs.fly_to_position || m.hdg_mode != options.afcs.fly_to_heading) {
      ++counts.refused;
      return counts.NotHeeded(unheeded::kImpossible,
                              fmt::format("FLY_TO with the modes {} and {}", m.pos_mode, m.hdg_mode));
    }
    if (!Follows("FLY_TO", {m.x, m.y, m.z, m.hdg})) return;
    aircraft.Send(PositionSetpoint{{m.x, m.y, m.z}, m.hdg});
    Transmit(wire::AfcsDesiredPosition{m.x, m.y, m.z, m.hdg});
  }
  void Obey(const wire::AfcsPlatform& m, Autopilot& aircraft) {
    if (!platform) return;
    if (m.mode == options.afcs.platform_relative && Possible({m.relative_yaw, m.relative_pitch}))
      platform->Turn(LookFromAircraft{m.relative_yaw, m.relative_pitch});
    else if (m.mode == options.afcs.platform_absolute && Possible({m.absolute_yaw, m.absolute_pitch}))
      platform->Turn(LookInN{m.absolute_yaw, m.absolute_pitch});
    else if (m.mode == options.afcs.platform_point && Possible({m.camera_n, m.camera_e, m.camera_d}))
      platform->Turn(LookAt{{m.camera_n, m.camera_e, m.camera_d}});
    else
      return counts.NotHeeded("turns of the camera that cannot be", fmt::format("PLATFORM {}", m.mode));
    Transmit(PlatformMessage(m.mode, aircraft.State()));
  }
  template <class Other>
  void Obey(const Other&, Autopilot&) {}  // says what we say

  // Angles as they are now; of the camera's place, the one it was told to look at, otherwise where its axis
  // meets the ground, the level of N's origin, and none if it looks above the horizon.
  wire::AfcsPlatform PlatformMessage(std::int16_t mode, const VehicleState& state) const {
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

  wire::AfcsState StateMessage(const VehicleState& s) const {
    const TaitBryan angles = TaitBryanFromRotation(s.R_NB.toRotationMatrix());
    wire::AfcsState m;
    m.phi = angles.roll, m.theta = angles.pitch, m.psi = angles.yaw;
    m.p = m.raw_p = s.w_B.x(), m.q = m.raw_q = s.w_B.y(), m.r = m.raw_r = s.w_B.z();
    m.x = s.p_NB.x(), m.y = s.p_NB.y(), m.z = s.p_NB.z();
    m.vx = s.v_N.x(), m.vy = s.v_N.y(), m.vz = s.v_N.z();
    m.rpm0 = s.landed ? 0 : static_cast<std::uint16_t>(std::lround(options.rotor_rpm));
    return m;
  }

  wire::AfcsGpsState GpsMessage(const VehicleState& s) const {
    wire::AfcsGpsState m;
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
  void Transmit(const wire::AfcsMessage& message) {
    last_sent = wire::After(last_sent, wire::AfcsTimeOf(t_s));
    error_code error;
    socket.send_to(asio::buffer(codec.Encode({last_sent, message})), *owner, 0, error);
  }

  const AfcsServerOptions options;
  const wire::AfcsProfile profile;
  const std::uint32_t open_id;
  const wire::AfcsCodec codec;
  wire::AfcsReceiver receiver;  // of the owner
  PanTilt* platform;
  asio::io_context io;
  udp::socket socket{io};
  std::array<std::uint8_t, 65536> buffer{};

  WireCounts counts;
  std::array<std::uint64_t, wire::kAfcsRefusals> refused{};  // by the receiver, as far as counted
  bool pilot_allows = true;
  std::optional<udp::endpoint> owner;  // of the session
  double now_s = 0, t_s = 0;           // ours, and the aircraft's
  double heard_s = 0, state_due_s = 0, gps_due_s = 0;
  wire::AfcsTime last_sent;
};

AfcsServer::AfcsServer(const AfcsServerOptions& options, PanTilt* platform)
    : session_(std::make_unique<Session>(options, platform)) {}
AfcsServer::~AfcsServer() = default;

void AfcsServer::Serve(double now_s, Autopilot& aircraft) { session_->Serve(now_s, aircraft); }
void AfcsServer::SetPilot(bool allows) { session_->pilot_allows = allows; }
const WireCounts& AfcsServer::Heard() const { return session_->counts; }
std::string AfcsServer::Where() const {
  error_code error;
  const udp::endpoint endpoint = session_->socket.local_endpoint(error);
  const std::string address = endpoint.address().to_string();
  return endpoint.address().is_v6() ? fmt::format("udp://[{}]:{}", address, endpoint.port())
                                    : fmt::format("udp://{}:{}", address, endpoint.port());
}

}  // namespace kestrel
