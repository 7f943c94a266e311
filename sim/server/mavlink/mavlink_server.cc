// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink/mavlink_server.h"

#include <array>
#include <boost/asio.hpp>
#include <chrono>
#include <optional>
#include <span>
#include <utility>

#include "base/diagnostics.h"
#include "control/link/network_address.h"
#include "control/link/session_socket.h"

namespace kestrel::sim {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

udp::endpoint Resolve(boost::asio::io_context& context, const control::UdpAddress& address) {
  error_code error;
  const auto found = udp::resolver(context).resolve(address.host, std::to_string(address.port), error);
  if (error) throw InputError({}, "address \"" + control::ToText(address) + "\": " + error.message());
  return *found.begin();
}

double TimeOfDay_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string PeerText(const udp::endpoint& peer) {
  return peer.address().to_string() + ":" + std::to_string(peer.port());
}

}  // namespace

struct MavlinkServer::Wire {
  explicit Wire(const MavlinkServerOptions& options) {
    address = {false, options.listen, static_cast<std::uint16_t>(options.port)};
    const udp::endpoint at = Resolve(context, address);
    error_code error;
    socket.Open(at, error);
    if (error) throw InputError({}, "address \"" + control::ToText(address) + "\": " + error.message());
    address.port = socket.Where().port();
    fixed = !options.peer.empty();
    if (fixed) socket.Own(Resolve(context, control::ParseUdpAddress(options.peer)));
  }

  control::UdpAddress address;
  boost::asio::io_context context;
  control::SessionSocket socket{context};
  bool fixed = false;  // whose the session is
  double heard_s = 0;
  double tell_s = 0;  // again that another has the session
  bool dated = false;
};

MavlinkServer::MavlinkServer(const MavlinkServerOptions& options)
    : wire_(std::make_unique<Wire>(options)), vehicle_(options) {}
MavlinkServer::~MavlinkServer() = default;

void MavlinkServer::Serve(double now_s, control::Autopilot& aircraft) {
  constexpr int kMost = 256;  // datagrams at once, lest a flood stops the flight
  Wire& wire = *wire_;
  if (!std::exchange(wire.dated, true)) vehicle_.SetDate(TimeOfDay_s() - now_s);
  const auto receive = [&](std::span<const std::uint8_t> datagram) {
    wire.heard_s = now_s;
    vehicle_.Receive(datagram, now_s, aircraft);
  };
  const auto hear_owner = [&] {
    for (int i = 0; i < kMost; ++i) {
      const auto datagram = wire.socket.FromOwner();
      if (!datagram) return;
      receive(datagram->bytes);
    }
  };
  // The owner first: whether it has been silent is known when there is nothing more of it.
  hear_owner();
  for (int i = 0; i < kMost; ++i) {
    const auto datagram = wire.socket.FromOthers();
    if (!datagram) break;
    const std::optional<udp::endpoint>& owner = wire.socket.owner();
    if (datagram->from != owner) {
      const bool opens = vehicle_.OpensSession(datagram->bytes);
      const bool taken = owner && (wire.fixed || now_s - wire.heard_s <= kSilent_s);
      if (taken || !opens) {
        vehicle_.received().CountIgnored(
            opens ? ignored::kSecondClient : ignored::kNoSession,
            PeerText(datagram->from) +
                (taken ? "; it is that of " + PeerText(*owner) : "; nobody has opened one"));
        if (opens && now_s >= wire.tell_s) {
          wire.tell_s = now_s + kTellAgain_s;
          wire.socket.Send(vehicle_.Refusal(), datagram->from);
        }
        continue;
      }
      wire.socket.Own(datagram->from);
      vehicle_.Greet();
    }
    receive(datagram->bytes);
    hear_owner();
  }
  for (const control::wire::Bytes& datagram : vehicle_.Due(now_s, aircraft))
    if (const auto& owner = wire.socket.owner()) wire.socket.Send(datagram, *owner);
}

void MavlinkServer::SetPilot(bool allows) { vehicle_.SetPilot(allows); }
std::string MavlinkServer::Where() const { return control::ToText(wire_->address); }

}  // namespace kestrel::sim
