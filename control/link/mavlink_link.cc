// SPDX-License-Identifier: Apache-2.0
#include "control/link/mavlink_link.h"

#include <boost/asio.hpp>
#include <chrono>
#include <mutex>
#include <optional>
#include <span>
#include <thread>

#include "base/diagnostics.h"
#include "base/stopwatch.h"
#include "control/link/session_socket.h"
#include "control/link/udp_address.h"

namespace kestrel::control {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr auto kTick = std::chrono::milliseconds(4);
constexpr int kMax = 256;  // datagrams at once, lest a flood stops what is due

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
        socket.Open(endpoint, error);
      } else {
        socket.Open(udp::endpoint(endpoint.protocol(), 0), error);
        if (!error) socket.Own(endpoint);
      }
    }
    if (error) throw InputError({}, "address \"" + text + "\": " + error.message());
    if (address.listen) address.port = socket.Where().port();
    Tick();
    thread = std::thread([this] { context.run(); });
  }
  ~Wire() {
    context.stop();
    thread.join();
  }

  // All that the autopilot sent, and some of what others did, who come after it.
  void Listen() {
    {
      const std::lock_guard lock(mutex);
      const double now_s = MonotonicNow_s();  // before its queue is empty, so that its silence is its own
      HearAutopilot(now_s);
      for (int i = 0; i < kMax; ++i) {
        const auto datagram = socket.FromOthers();
        if (!datagram) break;
        if (datagram->from != socket.owner()) {
          if (!address.listen || (socket.owner() && session.Open(now_s)) ||
              !session.IsAutopilot(datagram->bytes))
            continue;
          socket.Own(datagram->from);
        }
        session.Receive(datagram->bytes, now_s);
        HearAutopilot(now_s);
      }
    }
    Flush();
    socket.WhenReadable([this] { Listen(); });
  }

  void HearAutopilot(double now_s) {
    for (int i = 0; i < kMax; ++i) {
      const auto datagram = socket.FromOwner();
      if (!datagram) return;
      session.Receive(datagram->bytes, now_s);
    }
  }

  void Tick() {
    socket.WhenReadable([this] { Listen(); });
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
      due = session.Due(MonotonicNow_s());
    }
    if (!socket.owner()) return;
    for (const wire::Bytes& datagram : due) {
      const error_code error = socket.Send(datagram, *socket.owner());
      const std::lock_guard lock(mutex);
      send_error = error ? "sending failed: " + error.message() : "";
    }
  }

  UdpAddress address;
  mutable std::mutex mutex;  // of session and send_error
  MavlinkSession session;
  std::string send_error;

  // The thread's own:
  boost::asio::io_context context{1};
  SessionSocket socket{context};
  boost::asio::steady_timer timer{context};
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
    wire_->session.Send(setpoint, MonotonicNow_s());
  }
  boost::asio::post(wire_->context, [wire = wire_.get()] { wire->Flush(); });
}

void MavlinkLink::Aid(const AttitudeAid&) {
  const std::lock_guard lock(wire_->mutex);
  wire_->session.Aid();
}

LinkHealth MavlinkLink::Health() const {
  const std::lock_guard lock(wire_->mutex);
  LinkHealth health = wire_->session.Health(MonotonicNow_s());
  if (!wire_->send_error.empty()) health.error = wire_->send_error;
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

void MavlinkLink::See(const Sighting& sighting) {
  const std::lock_guard lock(wire_->mutex);
  wire_->session.See(sighting);
}

std::string MavlinkLink::Where() const { return ToText(wire_->address); }

}  // namespace kestrel::control
