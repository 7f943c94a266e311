// SPDX-License-Identifier: Apache-2.0
#include "flight/live/connection.h"

#include <boost/asio/dispatch.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <string_view>
#include <utility>

#include "flight/live/foxglove.h"

namespace kestrel::flight {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

constexpr std::size_t kMaxHead_bytes = 16 << 10, kMaxBody_bytes = 4 << 10, kMaxMessage_bytes = 64 << 10;
// Beyond it a viewer who is slow is not ahead of what it is shown.
constexpr int kSendBuffer_bytes = 256 << 10;
// What the page holds is its own; it asks nobody but this server.
constexpr char kPolicy[] =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "media-src data: blob:; connect-src 'self' ws: data: blob:; frame-ancestors 'none'";

std::string_view View(beast::string_view text) { return {text.data(), text.size()}; }

// The one of Foxglove's that the client offers; empty: none.
std::string SubprotocolOf(std::string_view offered) {
  while (!offered.empty()) {
    const std::size_t comma = offered.find(',');
    std::string_view each = offered.substr(0, comma);
    while (each.starts_with(' ')) each.remove_prefix(1);
    while (each.ends_with(' ')) each.remove_suffix(1);
    for (const char* known : Foxglove::kSubprotocols)
      if (each == known) return known;
    offered.remove_prefix(comma == std::string_view::npos ? offered.size() : comma + 1);
  }
  return {};
}

std::shared_ptr<const std::string> Line(std::string text) {
  return std::make_shared<const std::string>(std::move(text) + '\n');
}

}  // namespace

Connection::Connection(boost::asio::ip::tcp::socket socket, const ConnectionHost& host)
    : stream_(std::move(socket)), host_(host) {
  beast::error_code ignored;
  auto& tcp = beast::get_lowest_layer(stream_).socket();
  tcp.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
  tcp.set_option(boost::asio::socket_base::send_buffer_size(kSendBuffer_bytes), ignored);
  parser_.header_limit(kMaxHead_bytes);
  parser_.body_limit(kMaxBody_bytes);
}

void Connection::Start() {
  since_s_ = host_.now_s();
  http::async_read(
      stream_.next_layer(), read_, parser_,
      [self = shared_from_this()](beast::error_code wrong, std::size_t) {
        if (wrong == http::error::end_of_stream || wrong == boost::asio::error::operation_aborted)
          return self->End();
        if (wrong == http::error::header_limit || wrong == http::error::body_limit)
          return self->Respond(413, "text/plain", Line("that request is too large"));
        if (wrong && wrong.category() == http::make_error_code(http::error::bad_target).category())
          return self->Respond(400, "text/plain", Line("that is no request of HTTP"));
        if (wrong) return self->End();
        self->Answer();
      });
}

void Connection::StartFull() {
  asked_ = true;
  since_s_ = host_.now_s();
  Respond(503, "text/plain", Line("too many are watching; valid: later"));
}

void Connection::Answer() {
  asked_ = true;
  const Request& request = parser_.get();
  const std::string_view target = View(request.target());
  const std::string subprotocol = SubprotocolOf(View(request[http::field::sec_websocket_protocol]));
  const std::string refusal =
      host_.access.Refusal({.host = View(request[http::field::host]),
                            .origin = View(request[http::field::origin]),
                            .target = target,
                            .foxglove = websocket::is_upgrade(request) && !subprotocol.empty()});
  if (!refusal.empty()) return Respond(403, "text/plain", Line(refusal));
  const std::string_view path = target.substr(0, target.find('?'));
  if (websocket::is_upgrade(request)) {
    if (!subprotocol.empty()) return Upgrade(true, subprotocol);
    if (path == "/live") return Upgrade(false, {});
    return Respond(404, "text/plain", Line("valid: /live, or Foxglove's subprotocol"));
  }
  if (request.method() != http::verb::get) return Respond(405, "text/plain", Line("valid: GET"));
  if (path != "/") return Respond(404, "text/plain", Line("valid: /"));
  const std::shared_ptr<const std::string> page = host_.page();
  if (!page)  // which comes by itself to who opened it too soon
    return Respond(
        503, "text/html; charset=utf-8",
        Line("<!doctype html><meta http-equiv=\"refresh\" content=\"1\"><p>no flight has begun yet</p>"));
  Respond(200, "text/html; charset=utf-8", page);
}

void Connection::Respond(unsigned status, const char* type, std::shared_ptr<const std::string> body) {
  struct Response {
    http::response<http::span_body<const char>> message;
    std::shared_ptr<const std::string> body;
  };
  auto response = std::make_shared<Response>();
  auto& message = response->message;
  response->body = std::move(body);
  message.version(11);
  message.result(status);
  message.set(http::field::content_type, type);
  message.set(http::field::cache_control, "no-store");
  message.set("Referrer-Policy", "no-referrer");  // which would have the token
  message.set("Content-Security-Policy", kPolicy);
  message.set("X-Content-Type-Options", "nosniff");
  message.keep_alive(false);
  message.body() = {response->body->data(), response->body->size()};
  message.prepare_payload();
  response_ = response;
  http::async_write(stream_.next_layer(), message,
                    [self = shared_from_this(), response](beast::error_code, std::size_t) {
                      beast::error_code ignored;
                      beast::get_lowest_layer(self->stream_)
                          .socket()
                          .shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
                      self->End();
                    });
}

void Connection::Upgrade(bool foxglove, const std::string& subprotocol) {
  websocket::stream_base::timeout timeout{std::chrono::seconds(10), std::chrono::seconds(30), true};
  stream_.set_option(timeout);  // who is gone without a word is noticed by the pings
  stream_.set_option(websocket::stream_base::decorator([subprotocol](websocket::response_type& response) {
    if (!subprotocol.empty()) response.set(http::field::sec_websocket_protocol, subprotocol);
  }));
  stream_.read_message_max(kMaxMessage_bytes);
  auto request = std::make_shared<Request>(parser_.release());
  stream_.async_accept(*request, [self = shared_from_this(), request, foxglove](beast::error_code wrong) {
    if (wrong || self->ended_) return self->End();
    self->upgraded_ = true;
    self->since_s_.reset();
    self->conversation_ = self->host_.join(foxglove);
    self->Read();
    self->Kick();
  });
}

void Connection::Read() {
  read_.clear();
  stream_.async_read(
      read_, [self = shared_from_this()](beast::error_code wrong, std::size_t) { self->Heard(wrong); });
}

void Connection::Heard(beast::error_code wrong) {
  if (wrong || ended_ || closing_) return End();
  switch (rate_.Take(host_.now_s())) {
    case RateLimit::Verdict::kTake:
      conversation_->Hear({static_cast<const char*>(read_.cdata().data()), read_.size()},
                          stream_.got_binary());
      break;
    case RateLimit::Verdict::kRefuse:
      if (rate_.first_refused()) conversation_->Refuse("too many messages at once; the next are not heeded");
      break;
    case RateLimit::Verdict::kPutOut:
      return Close(websocket::close_code::policy_error, "too many messages");
  }
  Kick();
  Read();
}

void Connection::Kick() {
  if (!upgraded_ || ended_ || closing_ || writing_) return;
  writing_ = conversation_->Next();
  if (!writing_) return;
  since_s_ = host_.now_s();
  stream_.binary(writing_->binary);
  stream_.async_write(boost::asio::buffer(*writing_->bytes),
                      [self = shared_from_this()](beast::error_code wrong, std::size_t) {
                        self->writing_.reset();
                        self->since_s_.reset();
                        if (wrong) return self->End();
                        self->Kick();
                      });
}

void Connection::Tick() {
  if (!since_s_ || ended_) return;
  const bool late = host_.now_s() - *since_s_ > (upgraded_ ? host_.frozen_s : host_.request_s);
  if (late) End();
}

void Connection::Close(websocket::close_code code, const char* why) {
  closing_ = true;
  since_s_ = host_.now_s();
  if (writing_) return End();  // nothing can be said in the middle of a message
  stream_.async_close({code, why}, [self = shared_from_this()](beast::error_code) { self->End(); });
}

void Connection::End() {
  if (ended_) return;
  ended_ = true;
  conversation_.reset();
  beast::error_code ignored;
  beast::get_lowest_layer(stream_).socket().close(ignored);
}

}  // namespace kestrel::flight
