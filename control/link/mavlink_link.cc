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
#include "control/link/network_address.h"
#include "control/link/session_socket.h"
#include "control/link/tcp_client.h"

namespace kestrel::control {
namespace {

using boost::asio::ip::tcp;
using boost::asio::ip::udp;
using boost::system::error_code;

constexpr auto kTick = std::chrono::milliseconds(4);
constexpr int kMax = 256;  // datagrams at once, lest a flood stops what is due

}  // namespace

struct MavlinkLink::Wire {
  Wire(const std::string& text, const MavlinkOptions& options) : session(options), where(text) {
    if (IsTcp(text))
      OpenTcp(ParseTcpAddress(text));
    else
      OpenUdp(ParseUdpAddress(text));
    Tick();
    thread = std::thread([this] { context.run(); });
  }
  ~Wire() {
    context.stop();
    thread.join();
  }

  void OpenUdp(UdpAddress address) {
    listens = address.listen;
    udp::resolver resolver(context);
    error_code error;
    const auto found = resolver.resolve(address.host, std::to_string(address.port), error);
    SessionSocket& socket = datagrams.emplace(context);
    if (!error) {
      const udp::endpoint endpoint = *found.begin();
      if (listens) {
        socket.Open(endpoint, error);
      } else {
        socket.Open(udp::endpoint(endpoint.protocol(), 0), error);
        if (!error) socket.Own(endpoint);
      }
    }
    if (error) throw InputError({}, "address \"" + where + "\": " + error.message());
    if (listens) address.port = socket.Where().port();
    where = ToText(address);
  }

  // A server that is not there yet, or leaves, is no mistake: it is waited for.
  void OpenTcp(const TcpAddress& address) {
    tcp::resolver resolver(context);
    error_code error;
    const auto found = resolver.resolve(address.host, std::to_string(address.port), error);
    if (error) throw InputError({}, "address \"" + where + "\": " + error.message());
    where = ToText(address);
    stream.emplace(context, TcpClient::Handlers{[this](std::span<const std::uint8_t> bytes) {
                                                  {
                                                    const std::lock_guard lock(mutex);
                                                    session.ReceiveStream(bytes, MonotonicNow_s());
                                                  }
                                                  Flush();
                                                },
                                                [this] {
                                                  const std::lock_guard lock(mutex);
                                                  session.BeginStream();
                                                  TellOfStream();
                                                }});
    stream->Open({found.begin(), found.end()});
  }

  // All that the autopilot sent, and some of what others did, who come after it.
  void Listen() {
    {
      const std::lock_guard lock(mutex);
      const double now_s = MonotonicNow_s();  // before its queue is empty, so that its silence is its own
      HearAutopilot(now_s);
      for (int i = 0; i < kMax; ++i) {
        const auto datagram = datagrams->FromOthers();
        if (!datagram) break;
        if (datagram->from != datagrams->owner()) {
          if (!listens || (datagrams->owner() && session.Open(now_s)) ||
              !session.IsAutopilot(datagram->bytes))
            continue;
          datagrams->Own(datagram->from);
        }
        session.Receive(datagram->bytes, now_s);
        HearAutopilot(now_s);
      }
    }
    Flush();
    datagrams->WhenReadable([this] { Listen(); });
  }

  void HearAutopilot(double now_s) {
    for (int i = 0; i < kMax; ++i) {
      const auto datagram = datagrams->FromOwner();
      if (!datagram) return;
      session.Receive(datagram->bytes, now_s);
    }
  }

  void Tick() {
    if (datagrams) datagrams->WhenReadable([this] { Listen(); });
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
    for (const wire::Bytes& message : due) {
      if (stream) {
        stream->Send(message);
        const std::lock_guard lock(mutex);
        TellOfStream();
      } else if (datagrams->owner()) {
        const error_code error = datagrams->Send(message, *datagrams->owner());
        const std::lock_guard lock(mutex);
        wire_error = error ? "sending failed: " + error.message() : "";
      }
    }
  }

  void TellOfStream() { wire_error = stream->Error().empty() ? "" : where + ": " + stream->Error(); }

  mutable std::mutex mutex;  // of session and wire_error
  MavlinkSession session;
  std::string wire_error;
  std::string where;  // as it is after the beginning
  bool listens = false;

  // The thread's own; one of datagrams and stream:
  boost::asio::io_context context{1};
  std::optional<SessionSocket> datagrams;
  std::optional<TcpClient> stream;
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
  if (!wire_->wire_error.empty()) health.error = wire_->wire_error;
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

std::string MavlinkLink::Where() const { return wire_->where; }

}  // namespace kestrel::control
