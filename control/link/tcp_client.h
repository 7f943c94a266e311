// SPDX-License-Identifier: Apache-2.0
#pragma once

// clang-format off
#include <utility>  // Asio of Boost 1.74 needs it and does not include it
// clang-format on

// For .cc files alone: Boost.Asio is slow to compile.
#include <array>
#include <boost/asio.hpp>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace kestrel::control {

// The client's end of a TCP connection that is to be there always: it is opened anew, every kAgain_s, while the
// server refuses it, does not answer within kPatience_s, or has left. All of it on the context's thread.
//
// What cannot be sent at once is left out, message by message, so that no setpoint waits behind older ones: the
// system's queue is kept short, and of a message that it took in part the rest goes first.
class TcpClient {
 public:
  using Endpoint = boost::asio::ip::tcp::endpoint;
  static constexpr double kAgain_s = 1, kPatience_s = 5;

  struct Handlers {
    std::function<void(std::span<const std::uint8_t>)> received;  // some bytes of the stream, cut anywhere
    // The connection is there, or has gone: a new stream begins, and Error() is another.
    std::function<void()> changed;
  };

  TcpClient(boost::asio::io_context& io, Handlers handlers);

  void Open(std::vector<Endpoint> servers);  // once; where a name has several addresses, each in turn
  // A whole message; while there is no connection it is lost.
  void Send(std::span<const std::uint8_t> message);
  bool open() const { return open_; }
  // Empty: there is a connection, and what is sent goes out. Otherwise what is the matter, in words.
  const std::string& Error() const { return error_; }

 private:
  void Connect();
  void Read();
  void Lose(const std::string& why);
  bool Write(std::span<const std::uint8_t> bytes);

  Handlers handlers_;
  boost::asio::ip::tcp::socket socket_;
  boost::asio::steady_timer timer_;
  std::vector<Endpoint> servers_;
  std::size_t tries_ = 0;
  std::uint64_t attempt_ = 0;  // handlers of an earlier one come late
  bool open_ = false;
  std::string error_ = "being connected";
  std::vector<std::uint8_t> rest_;  // of a message that went out in part
  std::array<std::uint8_t, 4096> buffer_{};
};

}  // namespace kestrel::control
