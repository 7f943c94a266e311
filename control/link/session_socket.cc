// SPDX-License-Identifier: Apache-2.0
#include "control/link/session_socket.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace kestrel::control {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr int kBacklog = 4096;         // what the others' queue may hold when a session begins
constexpr std::size_t kEarlier = 256;  // of the owner's among them; more is not what a peer says by itself

// Two sockets may share a port while both allow it. With SO_REUSEPORT, unlike SO_REUSEADDR, the system gives
// it to nobody but the same user.
void Share(udp::socket& socket, bool allowed, error_code& error) {
  const int value = allowed ? 1 : 0;
  if (::setsockopt(socket.native_handle(), SOL_SOCKET, SO_REUSEPORT, &value, sizeof value) != 0)
    error = error_code(errno, boost::system::system_category());
}

}  // namespace

void SessionSocket::Open(const Endpoint& at, error_code& error) {
  if (others_.open(at.protocol(), error)) return;
  if (others_.bind(at, error)) return;
  others_.non_blocking(true, error);
}

void SessionSocket::Own(const Endpoint& owner) {
  Release();
  owner_ = owner;
  Connect();
}

void SessionSocket::Connect() {
  error_code error, ignored;
  owners_.open(owner_->protocol(), error);
  if (!error) Share(owners_, true, error);
  if (!error) Share(others_, true, error);
  if (!error) owners_.bind(others_.local_endpoint(), error);
  if (!error) owners_.connect(*owner_, error);
  if (!error) owners_.non_blocking(true, error);
  Share(others_, false, ignored);
  if (owners_.is_open()) Share(owners_, false, ignored);
  if (error) {
    owners_.close(ignored);
    return;
  }
  // In the order in which it came: commands that were overtaken by later ones would be obeyed after them.
  Bytes buffer(buffer_.size());
  for (int i = 0; i < kBacklog; ++i) {
    const auto datagram = Next(others_, buffer);
    if (!datagram) return;
    if (datagram->from == owner_ && earlier_.size() < kEarlier)
      earlier_.emplace_back(datagram->bytes.begin(), datagram->bytes.end());
  }
}

void SessionSocket::Release() {
  error_code ignored;
  owners_.close(ignored);
  owner_.reset();
  earlier_.clear();
}

std::optional<SessionSocket::Datagram> SessionSocket::FromOwner() {
  if (!earlier_.empty()) {
    const Bytes bytes = std::move(earlier_.front());
    earlier_.pop_front();
    std::copy(bytes.begin(), bytes.end(), buffer_.begin());
    return Datagram{*owner_, std::span(buffer_).first(bytes.size())};
  }
  // Between its binding and its connecting anybody's came here: strangers' are passed over.
  while (owners_.is_open()) {
    const auto datagram = Next(owners_, buffer_);
    if (!datagram || datagram->from == owner_) return datagram;
  }
  return std::nullopt;
}

std::optional<SessionSocket::Datagram> SessionSocket::FromOthers() { return Next(others_, buffer_); }

std::optional<SessionSocket::Datagram> SessionSocket::Next(udp::socket& socket, Bytes& buffer) {
  // That nobody was at home where something was sent is told once, by an error in place of a datagram.
  for (int tries = 0; tries < 3; ++tries) {
    Datagram datagram;
    error_code error;
    const std::size_t size = socket.receive_from(boost::asio::buffer(buffer), datagram.from, 0, error);
    if (error == boost::asio::error::would_block) return std::nullopt;
    if (error) continue;
    datagram.bytes = std::span(buffer).first(size);
    return datagram;
  }
  return std::nullopt;
}

error_code SessionSocket::Send(std::span<const std::uint8_t> bytes, const Endpoint& to) {
  if (owner_ && !owners_.is_open()) Connect();
  error_code error;
  others_.send_to(boost::asio::buffer(bytes.data(), bytes.size()), to, 0, error);
  return error;
}

void SessionSocket::Wait(int most_ms) {
  std::array<pollfd, 2> sockets{
      {{others_.native_handle(), POLLIN, 0}, {owners_.is_open() ? owners_.native_handle() : -1, POLLIN, 0}}};
  ::poll(sockets.data(), sockets.size(), most_ms);
}

}  // namespace kestrel::control
