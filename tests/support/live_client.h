// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace kestrel {

// A viewer of a live flight on this computer.
class LiveClient {
 public:
  explicit LiveClient(std::uint16_t port, int receive_buffer = 0) : stream_(io_), port_(port) {
    boost::asio::ip::tcp::socket& socket = boost::beast::get_lowest_layer(stream_).socket();
    socket.open(boost::asio::ip::tcp::v4());
    if (receive_buffer) socket.set_option(boost::asio::socket_base::receive_buffer_size(receive_buffer));
    socket.connect({boost::asio::ip::address_v4::loopback(), port});
  }
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }

  // As a browser or another program asks for a WebSocket; false: it was refused, and why() says so.
  bool Join(const std::string& target, const std::string& subprotocol = "", const std::string& origin = "",
            const std::string& as_host = "") {
    stream_.set_option(
        boost::beast::websocket::stream_base::decorator([&](boost::beast::websocket::request_type& request) {
          if (!subprotocol.empty())
            request.set(boost::beast::http::field::sec_websocket_protocol, subprotocol);
          if (!origin.empty()) request.set(boost::beast::http::field::origin, origin);
        }));
    boost::beast::websocket::response_type response;
    boost::beast::error_code wrong;
    // Not by handshake(), which does not hand over the response of a server that refuses.
    stream_.async_handshake(response, as_host.empty() ? host() : as_host, target,
                            [&](boost::beast::error_code is) { wrong = is; });
    io_.restart();
    io_.run();
    chosen_ = std::string(response[boost::beast::http::field::sec_websocket_protocol]);
    status_ = response.result_int();
    return !wrong;
  }
  void Say(const std::string& text, bool binary = false) {
    stream_.binary(binary);
    stream_.write(boost::asio::buffer(text));
  }
  // The next message; an empty one: the connection is closed.
  std::string Hear() {
    boost::beast::flat_buffer buffer;
    boost::beast::error_code wrong;
    stream_.read(buffer, wrong);
    return wrong ? "" : boost::beast::buffers_to_string(buffer.data());
  }
  bool binary() const { return stream_.got_binary(); }
  // The next message of JSON with this op.
  nlohmann::json HearOp(const std::string& op) {
    for (;;) {
      const std::string text = Hear();
      if (text.empty()) return {};
      if (!binary() && nlohmann::json::parse(text)["op"] == op) return nlohmann::json::parse(text);
    }
  }
  // Bytes as they are; it may be closed before all have been said.
  void Raw(const std::string& bytes) {
    boost::beast::error_code ignored;
    boost::asio::write(boost::beast::get_lowest_layer(stream_).socket(), boost::asio::buffer(bytes), ignored);
  }
  std::string RawAnswer() {
    std::string all;
    boost::beast::error_code wrong;
    boost::asio::read(boost::beast::get_lowest_layer(stream_).socket(), boost::asio::dynamic_buffer(all),
                      wrong);
    return all;
  }
  const std::string& chosen() const { return chosen_; }
  unsigned status() const { return status_; }

 private:
  boost::asio::io_context io_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  std::uint16_t port_;
  std::string chosen_;
  unsigned status_ = 0;
};

}  // namespace kestrel
