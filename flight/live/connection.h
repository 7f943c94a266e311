// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "flight/live/access.h"
#include "flight/live/conversation.h"
#include "flight/live/rate_limit.h"

namespace kestrel::flight {

// What all connections of a server share.
struct ConnectionHost {
  Access access;
  std::function<double()> now_s;
  std::function<std::shared_ptr<const std::string>()> page;
  std::function<std::unique_ptr<Conversation>(bool foxglove)> join;
  // How long a request, a closing and one message to a viewer may take.
  double request_s = 10, frozen_s = 10;
};

// One connection: a request for the page, or a viewer by WebSocket. It lives while something is under way for
// it. Whatever comes is answered, or the connection is closed; nothing throws.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(boost::asio::ip::tcp::socket socket, const ConnectionHost& host);

  void Start();
  void StartFull();  // says that there are too many, and ends
  void Kick();       // there may be something new to say
  void Tick();       // ends what takes too long
  void End();        // at once
  bool viewer() const { return conversation_ != nullptr && !ended_; }
  bool asking() const { return !asked_ && !ended_; }  // its request is not whole yet

 private:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;

  void Answer();
  void Respond(unsigned status, const char* type, std::shared_ptr<const std::string> body);
  void Upgrade(bool foxglove, const std::string& subprotocol);
  void Read();
  void Heard(boost::beast::error_code wrong);
  void Close(boost::beast::websocket::close_code code, const char* why);

  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  const ConnectionHost& host_;
  boost::beast::flat_buffer read_;
  boost::beast::http::request_parser<boost::beast::http::string_body> parser_;
  std::shared_ptr<void> response_;
  std::unique_ptr<Conversation> conversation_;  // null: no viewer
  std::optional<LiveMessage> writing_;
  RateLimit rate_;
  std::optional<double> since_s_;  // when what is under way began: a request, a message to the viewer
  bool asked_ = false, upgraded_ = false, closing_ = false, ended_ = false;
};

}  // namespace kestrel::flight
