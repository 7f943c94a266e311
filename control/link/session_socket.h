// SPDX-License-Identifier: Apache-2.0
#pragma once

// clang-format off
#include <utility>  // Asio of Boost 1.74 needs it and does not include it
// clang-format on

// For .cc files alone: Boost.Asio is slow to compile.
#include <boost/asio.hpp>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

namespace kestrel::control {

// A UDP port at which one peer at a time has the session. What its owner sends has a queue of its own in the
// kernel, which no other sender can fill: a second socket on the port, connected to it, to which the kernel
// gives what comes from there. However much others send, what the owner sent is found, and a session may
// be judged by its owner's silence: nothing is left in that queue. Who judges it must have taken the time
// before that queue was found empty, or a thread that slept in between would take its own silence for the
// owner's.
//
// A peer that speaks to another address of this computer than the one that the system would answer it from is
// heard among the others, as it would be without such a queue.
class SessionSocket {
 public:
  using Endpoint = boost::asio::ip::udp::endpoint;
  struct Datagram {
    Endpoint from;
    std::span<const std::uint8_t> bytes;  // until the next is taken
  };

  explicit SessionSocket(boost::asio::io_context& io) : others_(io), owners_(io) {}

  // No other user's program may ever bind the port, and none at all but while a session's queue is made.
  void Open(const Endpoint& at, boost::system::error_code& error);
  Endpoint Where() const { return others_.local_endpoint(); }

  // Whose session it is from now on, instead of another's. What it sent before is its queue's first, and of
  // what others sent before nothing is kept. What was taken last is still there. If the system has no second
  // socket to give, the owner's are among the others', until Send finds that it has.
  void Own(const Endpoint& owner);
  void Release();
  const std::optional<Endpoint>& owner() const { return owner_; }

  // The next that has come; none: the queue is empty.
  std::optional<Datagram> FromOwner();
  std::optional<Datagram> FromOthers();

  // What cannot be sent is lost, as anything on UDP may be.
  boost::system::error_code Send(std::span<const std::uint8_t> bytes, const Endpoint& to);

  // Until something has come, or for so long.
  void Wait(int most_ms);
  // On the context's thread, when something has come; to be called again after that.
  template <class Handler>
  void WhenReadable(Handler handler) {
    const auto wait = [&](boost::asio::ip::udp::socket& socket, bool& waits) {
      if (!socket.is_open() || waits) return;
      waits = true;
      socket.async_wait(boost::asio::ip::udp::socket::wait_read,
                        [&waits, handler](const boost::system::error_code& error) {
                          waits = false;
                          if (!error) handler();
                        });
    };
    wait(owners_, owners_wait_);
    wait(others_, others_wait_);
  }

 private:
  using Bytes = std::vector<std::uint8_t>;
  std::optional<Datagram> Next(boost::asio::ip::udp::socket& socket, Bytes& buffer);
  void Connect();

  boost::asio::ip::udp::socket others_, owners_;
  bool others_wait_ = false, owners_wait_ = false;
  std::optional<Endpoint> owner_;
  std::deque<Bytes> earlier_;  // of the owner's, from before it had a queue of its own
  Bytes buffer_ = Bytes(65536);
};

}  // namespace kestrel::control
