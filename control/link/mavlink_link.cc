// SPDX-License-Identifier: Apache-2.0
#include "control/link/mavlink_link.h"

#include <array>
#include <boost/asio.hpp>
#include <chrono>
#include <mutex>
#include <optional>
#include <span>
#include <thread>

#include "base/yaml/yaml_fields.h"
#include "control/link/udp_address.h"

namespace kestrel {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr auto kTick = std::chrono::milliseconds(4);

double Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

struct MavlinkLink::Wire {
  Wire(const std::string& text, const MavlinkOptions& options)
      : address(ParseUdpAddress(text)), session(options) {
    udp::resolver resolver(context);
    error_code error;
    const auto found = resolver.resolve(address.host, std::to_string(address.port), error);
    if (!error) {
      const udp::endpoint endpoint = *found.begin();
      if (address.listen) {
        Open(endpoint, error);
      } else {
        Open(udp::endpoint(endpoint.protocol(), 0), error);
        peer = endpoint;
      }
    }
    if (error) throw InputError({"address \"" + text + "\": " + error.message()});
    if (address.listen) address.port = socket.local_endpoint().port();
    Receive();
    Tick();
    thread = std::thread([this] { context.run(); });
  }
  ~Wire() {
    context.stop();
    thread.join();
  }

  void Open(const udp::endpoint& at, error_code& error) {
    if (socket.open(at.protocol(), error)) return;
    if (socket.bind(at, error)) return;
    socket.non_blocking(true, error);
  }

  void Receive() {
    socket.async_receive_from(boost::asio::buffer(buffer), from, [this](error_code error, std::size_t size) {
      receiving = !error;
      if (error) return;  // tried again by Tick
      Take({buffer.data(), size});
      Receive();
    });
    receiving = true;
  }

  void Take(std::span<const std::uint8_t> datagram) {
    {
      const std::lock_guard lock(mutex);
      const double now_s = Now_s();
      if (address.listen && from != peer) {
        if ((peer && session.Open(now_s)) || !session.IsAutopilot(datagram)) return;
        peer = from;
      }
      if (from != peer) return;
      session.Hear(datagram, now_s);
    }
    Flush();
  }

  void Tick() {
    if (!receiving) Receive();
    Flush();
    timer.expires_after(kTick);
    timer.async_wait([this](error_code error) {
      if (!error) Tick();
    });
  }

  void Flush() {
    std::vector<wire::Bytes> due;
    {
      const std::lock_guard lock(mutex);
      due = session.Due(Now_s());
    }
    if (!peer) return;
    for (const wire::Bytes& datagram : due) {
      error_code error;
      socket.send_to(boost::asio::buffer(datagram), *peer, 0, error);
      const std::lock_guard lock(mutex);
      trouble = error ? "sending failed: " + error.message() : "";
    }
  }

  UdpAddress address;
  mutable std::mutex mutex;  // of session and trouble
  MavlinkSession session;
  std::string trouble;

  // The thread's own:
  boost::asio::io_context context{1};
  udp::socket socket{context};
  boost::asio::steady_timer timer{context};
  std::array<std::uint8_t, 2048> buffer{};
  udp::endpoint from;
  std::optional<udp::endpoint> peer;
  bool receiving = false;
  std::thread thread;
};

MavlinkLink::MavlinkLink(const std::string& address, const MavlinkOptions& options)
    : wire_(std::make_unique<Wire>(address, options)) {}
MavlinkLink::~MavlinkLink() = default;

VehicleState MavlinkLink::State() const {
  const std::lock_guard lock(wire_->mutex);
  return wire_->session.State();
}

void MavlinkLink::Send(const Setpoint& setpoint) {
  {
    const std::lock_guard lock(wire_->mutex);
    wire_->session.Send(setpoint, Now_s());
  }
  boost::asio::post(wire_->context, [wire = wire_.get()] { wire->Flush(); });
}

void MavlinkLink::Aid(const AttitudeAid&) {
  const std::lock_guard lock(wire_->mutex);
  wire_->session.Aid();
}

LinkHealth MavlinkLink::Health() const {
  const std::lock_guard lock(wire_->mutex);
  LinkHealth health = wire_->session.Health(Now_s());
  if (!wire_->trouble.empty()) health.trouble = wire_->trouble;
  return health;
}

void MavlinkLink::Silence() {
  const std::lock_guard lock(wire_->mutex);
  wire_->session.Silence();
}

void MavlinkLink::TakeControl() {
  const std::lock_guard lock(wire_->mutex);
  wire_->session.TakeControl();
}

void MavlinkLink::ShowTarget(const Eigen::Vector3d& p_NT) {
  const std::lock_guard lock(wire_->mutex);
  wire_->session.ShowTarget(p_NT);
}

std::string MavlinkLink::Where() const { return ToText(wire_->address); }

}  // namespace kestrel
