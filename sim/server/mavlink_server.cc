// SPDX-License-Identifier: Apache-2.0
#include "sim/server/mavlink_server.h"

#include <array>
#include <boost/asio.hpp>
#include <optional>
#include <span>

#include "base/yaml/yaml_fields.h"
#include "control/link/udp_address.h"

namespace kestrel {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

udp::endpoint Resolve(boost::asio::io_context& context, const UdpAddress& address) {
  error_code error;
  const auto found = udp::resolver(context).resolve(address.host, std::to_string(address.port), error);
  if (error) throw InputError({"address \"" + ToText(address) + "\": " + error.message()});
  return *found.begin();
}

std::string TextOf(const udp::endpoint& peer) {
  return peer.address().to_string() + ":" + std::to_string(peer.port());
}

}  // namespace

struct MavlinkServer::Wire {
  explicit Wire(const MavlinkServerOptions& options) {
    address = {false, options.listen, static_cast<std::uint16_t>(options.port)};
    const udp::endpoint at = Resolve(context, address);
    error_code error;
    if (!socket.open(at.protocol(), error) && !socket.bind(at, error)) socket.non_blocking(true, error);
    if (error) throw InputError({"address \"" + ToText(address) + "\": " + error.message()});
    address.port = socket.local_endpoint().port();
    if (!options.peer.empty()) peer = fixed = Resolve(context, ParseUdpAddress(options.peer));
  }

  UdpAddress address;
  boost::asio::io_context context;
  udp::socket socket{context};
  std::array<std::uint8_t, 2048> buffer{};
  std::optional<udp::endpoint> fixed, peer;
  double heard_s = 0;
  double tell_s = 0;  // again that another has the session
};

MavlinkServer::MavlinkServer(const MavlinkServerOptions& options)
    : wire_(std::make_unique<Wire>(options)), vehicle_(options) {}
MavlinkServer::~MavlinkServer() = default;

void MavlinkServer::Serve(double now_s, Autopilot& aircraft) {
  constexpr int kMost = 256;  // datagrams at once, lest a flood stops the flight
  Wire& wire = *wire_;
  for (int i = 0; i < kMost; ++i) {
    udp::endpoint from;
    error_code error;
    const std::size_t size = wire.socket.receive_from(boost::asio::buffer(wire.buffer), from, 0, error);
    if (error) break;
    const std::span<const std::uint8_t> datagram(wire.buffer.data(), size);
    const bool taken = wire.peer && (wire.fixed || now_s - wire.heard_s <= kSilent_s);
    if (from != wire.peer) {
      const bool opens = vehicle_.OpensSession(datagram);
      if (taken || !opens) {
        vehicle_.heard().NotHeeded(
            opens ? unheeded::kSecondClient : unheeded::kNoSession,
            TextOf(from) + (taken ? "; it is that of " + TextOf(*wire.peer) : "; nobody has opened one"));
        if (opens && now_s >= wire.tell_s) {
          wire.tell_s = now_s + kTellAgain_s;
          wire.socket.send_to(boost::asio::buffer(vehicle_.Refusal()), from, 0, error);
        }
        continue;
      }
      wire.peer = from;
      vehicle_.Greet();
    }
    wire.heard_s = now_s;
    vehicle_.Hear(datagram, now_s, aircraft);
  }
  for (const wire::Bytes& datagram : vehicle_.Due(now_s, aircraft)) {
    error_code error;  // as lost as any other datagram
    if (wire.peer) wire.socket.send_to(boost::asio::buffer(datagram), *wire.peer, 0, error);
  }
}

void MavlinkServer::SetPilot(bool allows) { vehicle_.SetPilot(allows); }
std::string MavlinkServer::Where() const { return ToText(wire_->address); }

}  // namespace kestrel
