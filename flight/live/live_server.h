// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "flight/live/connection.h"
#include "flight/live/live_options.h"

namespace kestrel::flight {

// Takes viewers, on the thread of an io_context. All but the constructor is of that thread.
class LiveServer {
 public:
  static constexpr std::size_t kMaxConnections = 64, kMaxAsking = 64;

  // Listens at once. page: null while there is none. Throws InputError: the address is none, or cannot be had.
  LiveServer(boost::asio::io_context& io, const LiveServerOptions& options, std::function<double()> now_s,
             std::function<std::shared_ptr<const std::string>()> page,
             std::function<std::unique_ptr<Conversation>(bool foxglove)> join);

  const std::string& url() const { return url_; }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  void Kick();  // there may be something new for the viewers
  int viewers() const;
  void End();

 private:
  void Listen(const LiveServerOptions& options);
  void Accept();
  void MakeRoom();
  void Tick();

  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer timer_;
  std::string url_;
  std::unique_ptr<ConnectionHost> host_;
  std::vector<std::weak_ptr<Connection>> connections_;
};

}  // namespace kestrel::flight
