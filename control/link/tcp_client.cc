// SPDX-License-Identifier: Apache-2.0
#include "control/link/tcp_client.h"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <chrono>
#include <utility>

namespace kestrel::control {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr int kQueue_bytes = 4096;  // a second of setpoints at most
constexpr unsigned kUnanswered_ms = 5000;

std::chrono::steady_clock::duration SecondsOf(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

TcpClient::TcpClient(boost::asio::io_context& io, Handlers handlers)
    : handlers_(std::move(handlers)), socket_(io), timer_(io) {}

void TcpClient::Open(std::vector<Endpoint> servers) {
  servers_ = std::move(servers);
  Connect();
}

void TcpClient::Connect() {
  const Endpoint& server = servers_[tries_++ % servers_.size()];
  const std::uint64_t attempt = ++attempt_;
  error_code error;
  socket_.open(server.protocol(), error);
  if (error) return Lose(error.message());
  // Before it is connected: what is then agreed on follows from it.
  socket_.set_option(tcp::socket::send_buffer_size(kQueue_bytes), error);
  socket_.async_connect(server, [this, attempt](error_code connected) {
    if (attempt != attempt_) return;
    timer_.cancel();
    if (connected) return Lose(connected.message());
    error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    socket_.non_blocking(true, ignored);
    // A cable that was pulled does not say so.
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &kUnanswered_ms,
                 sizeof kUnanswered_ms);
    open_ = true;
    error_.clear();
    handlers_.changed();
    Read();
  });
  timer_.expires_after(SecondsOf(kPatience_s));
  timer_.async_wait([this, attempt](error_code cancelled) {
    if (!cancelled && attempt == attempt_ && !open_) Lose("does not answer");
  });
}

void TcpClient::Read() {
  socket_.async_read_some(boost::asio::buffer(buffer_),
                          [this, attempt = attempt_](error_code error, std::size_t size) {
                            if (attempt != attempt_) return;
                            if (error == boost::asio::error::eof)
                              return Lose("the other end has closed the connection");
                            if (error) return Lose(error.message());
                            handlers_.received(std::span(buffer_).first(size));
                            if (attempt == attempt_) Read();
                          });
}

void TcpClient::Lose(const std::string& why) {
  const std::uint64_t attempt = ++attempt_;
  error_code ignored;
  socket_.close(ignored);
  open_ = false;
  rest_.clear();
  error_ = why + "; tried again every second";
  handlers_.changed();
  timer_.expires_after(SecondsOf(kAgain_s));
  timer_.async_wait([this, attempt](error_code cancelled) {
    if (!cancelled && attempt == attempt_) Connect();
  });
}

// False: not all of it went out. What is left of a message that went out in part is kept.
bool TcpClient::Write(std::span<const std::uint8_t> bytes) {
  error_code error;
  const std::size_t size = socket_.write_some(boost::asio::buffer(bytes.data(), bytes.size()), error);
  if (error && error != boost::asio::error::would_block) {
    Lose(error.message());
    return false;
  }
  const std::span<const std::uint8_t> left = bytes.subspan(error ? 0 : size);
  // Of what was not begun nothing is owed.
  const bool begun = bytes.data() == rest_.data() || left.size() < bytes.size();
  std::vector<std::uint8_t> rest(begun ? left.begin() : left.end(), left.end());
  rest_ = std::move(rest);
  return left.empty();
}

void TcpClient::Send(std::span<const std::uint8_t> message) {
  if (!open_) return;
  const bool all = (rest_.empty() || Write(rest_)) && Write(message);
  if (open_) error_ = all ? "" : "the other end does not read: messages are left out";
}

}  // namespace kestrel::control
