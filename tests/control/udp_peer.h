// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "control/wire/afcs.h"

namespace kestrel::control {

// Until it holds, for much longer than it could take on a machine that has other things to do.
inline bool Eventually(const std::function<bool()>& holds) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

inline double MonotonicTestNow_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The other end of a wire under test: a socket on the loopback address that says what it is told to.
class UdpPeer {
 public:
  using Endpoint = boost::asio::ip::udp::endpoint;
  static Endpoint Loopback(int port) {
    return {boost::asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)};
  }

  explicit UdpPeer(int port = 0) : socket_(io_, Loopback(port)) { socket_.non_blocking(true); }

  int port() const { return socket_.local_endpoint().port(); }
  void To(const Endpoint& endpoint) { to_ = endpoint; }
  const Endpoint& to() const { return to_; }  // or who sent what was received last

  void Send(const wire::Bytes& bytes) { socket_.send_to(boost::asio::buffer(bytes), to_); }
  void Send(const wire::AfcsTime& time, const wire::AfcsMessage& message) {
    Send(codec_.Encode({time, message}));
  }
  // The next that has come, from anybody; who sent it is whom Send answers.
  std::optional<wire::AfcsDatagram> Receive() {
    std::vector<std::uint8_t> buffer(65536);
    boost::system::error_code error;
    const std::size_t size = socket_.receive_from(boost::asio::buffer(buffer), to_, 0, error);
    if (error) return std::nullopt;
    buffer.resize(size);
    return std::get<wire::AfcsDatagram>(codec_.Decode(buffer));
  }

 private:
  boost::asio::io_context io_;
  boost::asio::ip::udp::socket socket_;
  Endpoint to_;
  wire::AfcsCodec codec_{wire::ThesisAfcsProfile()};
};

}  // namespace kestrel::control
