// SPDX-License-Identifier: Apache-2.0
#include "sim/server/udp_relay.h"

// clang-format off
#include <utility>  // Asio of Boost 1.74 needs it and does not include it
#include <boost/asio.hpp>
// clang-format on

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "base/random.h"
#include "base/stopwatch.h"

namespace kestrel::sim {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

}  // namespace

struct UdpRelay::Line {
  struct Datagram {
    bool to_server = false;
    std::uint64_t number = 0;  // of its direction, as they came
    std::vector<std::uint8_t> bytes;
  };
  // One side of the line: what comes in here goes out on the other.
  struct Side {
    explicit Side(boost::asio::io_context& context)
        : socket(context, udp::endpoint(boost::asio::ip::address_v4::loopback(), 0)) {
      socket.non_blocking(true);
    }
    udp::socket socket;
    udp::endpoint from;
    std::array<std::uint8_t, 65536> buffer{};
    std::uint64_t came = 0, left = 0;  // numbers of the newest
  };

  Line(const std::string& to_address, int to_port, std::uint64_t seed)
      : server(boost::asio::ip::make_address(to_address), static_cast<std::uint16_t>(to_port)),
        random(seed, "udp relay") {
    Listen(clients);
    Listen(servers);
    thread = std::thread([this] { context.run(); });
  }
  ~Line() {
    boost::asio::post(context, [this] { context.stop(); });
    thread.join();
  }

  void Listen(Side& side) {
    side.socket.async_receive_from(boost::asio::buffer(side.buffer), side.from,
                                   [this, &side](error_code error, std::size_t size) {
                                     // Refused: what was sent before found nobody.
                                     if (error == boost::asio::error::operation_aborted) return;
                                     if (!error) Handle(side, size);
                                     Listen(side);
                                   });
  }

  void Handle(Side& side, std::size_t size) {
    const bool to_server = &side == &clients;
    if (to_server)
      client = side.from;
    else if (side.from != server)
      return;
    const std::lock_guard lock(mutex);
    ++side.came;
    if (faults.cut || random.Uniform(0, 1) < faults.lost) {
      ++counts.lost;
      return;
    }
    const bool twice = random.Uniform(0, 1) < faults.doubled;
    if (twice) ++counts.doubled;
    const double now_s = MonotonicNow_s();
    for (int i = 0; i < (twice ? 2 : 1); ++i)
      under_way.emplace(now_s + faults.delay_s + faults.scatter_s * random.Uniform(0, 1),
                        Datagram{to_server, side.came, {side.buffer.data(), side.buffer.data() + size}});
    Deliver();
  }

  // With the lock held.
  void Deliver() {
    while (!under_way.empty() && under_way.begin()->first <= MonotonicNow_s()) {
      const Datagram datagram = std::move(under_way.begin()->second);
      under_way.erase(under_way.begin());
      if (!datagram.to_server && !client) continue;
      Side& out = datagram.to_server ? servers : clients;
      error_code error;  // lost like any other
      out.socket.send_to(boost::asio::buffer(datagram.bytes), datagram.to_server ? server : *client, 0,
                         error);
      ++counts.passed;
      if (datagram.number < out.left) ++counts.overtaken;
      out.left = std::max(out.left, datagram.number);
    }
    if (under_way.empty()) return;
    const double left_s = under_way.begin()->first - MonotonicNow_s();
    timer.expires_after(std::chrono::microseconds(std::max<std::int64_t>(0, std::int64_t(1e6 * left_s))));
    timer.async_wait([this](error_code error) {
      if (error) return;
      const std::lock_guard lock(mutex);
      Deliver();
    });
  }

  boost::asio::io_context context{1};
  Side clients{context}, servers{context};
  boost::asio::steady_timer timer{context};
  const udp::endpoint server;
  std::optional<udp::endpoint> client;

  mutable std::mutex mutex;  // of what follows
  RandomStream random;
  LineFaults faults;
  LineCounts counts;
  std::multimap<double, Datagram> under_way;  // by when it arrives; what is due at one time stays in order

  std::thread thread;
};

UdpRelay::UdpRelay(const std::string& to_address, int to_port, std::uint64_t seed)
    : line_(std::make_unique<Line>(to_address, to_port, seed)) {}
UdpRelay::~UdpRelay() = default;

int UdpRelay::port() const { return line_->clients.socket.local_endpoint().port(); }

void UdpRelay::Set(const LineFaults& faults) {
  const std::lock_guard lock(line_->mutex);
  line_->faults = faults;
  if (faults.cut) {
    line_->counts.lost += static_cast<std::int64_t>(line_->under_way.size());
    line_->under_way.clear();
  }
}

LineCounts UdpRelay::counts() const {
  const std::lock_guard lock(line_->mutex);
  return line_->counts;
}

}  // namespace kestrel::sim
