// SPDX-License-Identifier: Apache-2.0
#include "flight/live/live_server.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/diagnostics.h"

namespace kestrel::flight {
namespace {

using boost::asio::ip::tcp;

constexpr std::chrono::milliseconds kTick(100);

boost::asio::ip::address AddressOf(const std::string& text) {
  boost::system::error_code wrong;
  const auto address = boost::asio::ip::make_address(text, wrong);
  if (wrong)
    throw InputError("--live-address", fmt::format("'{}' is no address", text),
                     "valid: one of this computer in digits, such as 127.0.0.1, or 0.0.0.0 for all of them");
  return address;
}

// As a browser elsewhere can open it.
std::string NameOf(const boost::asio::ip::address& address) {
  char name[256] = {};
  if (address.is_unspecified() && gethostname(name, sizeof name - 1) == 0) return name;
  return address.is_v6() ? fmt::format("[{}]", address.to_string()) : address.to_string();
}

}  // namespace

LiveServer::LiveServer(boost::asio::io_context& io, const LiveServerOptions& options,
                       std::function<double()> now_s,
                       std::function<std::shared_ptr<const std::string>()> page,
                       std::function<std::unique_ptr<Conversation>(bool)> join)
    : acceptor_(io), timer_(io) {
  Listen(options);
  const std::string token = IsLoopback(options.address) ? "" : RandomToken();
  host_ = std::make_unique<ConnectionHost>(
      ConnectionHost{.access = Access(options.address, token, options.origins),
                     .now_s = std::move(now_s),
                     .page = std::move(page),
                     .join = std::move(join),
                     .frozen_s = options.frozen_s});
  url_ = fmt::format("http://{}:{}/{}{}", NameOf(acceptor_.local_endpoint().address()), port(),
                     token.empty() ? "" : "?token=", token);
  Accept();
  Tick();
}

void LiveServer::Listen(const LiveServerOptions& options) {
  const tcp::endpoint where(AddressOf(options.address), options.port);
  boost::system::error_code wrong;
  acceptor_.open(where.protocol(), wrong);
  if (!wrong) acceptor_.set_option(tcp::acceptor::reuse_address(true), wrong);
  if (!wrong) acceptor_.bind(where, wrong);
  if (!wrong) acceptor_.listen(boost::asio::socket_base::max_listen_connections, wrong);
  if (wrong == boost::system::errc::address_not_available)
    throw InputError("--live-address", fmt::format("'{}' is no address of this computer", options.address),
                     "valid: one of this computer, or 0.0.0.0 for all of them");
  if (wrong)
    throw InputError(
        "--live",
        fmt::format("port {} of {} cannot be had: {}", options.port, options.address, wrong.message()),
        "valid: --live 0 for any that is free, or another port");
}

void LiveServer::Accept() {
  acceptor_.async_accept([this](boost::system::error_code wrong, tcp::socket socket) {
    if (wrong == boost::asio::error::operation_aborted || !acceptor_.is_open()) return;
    if (!wrong) {
      auto connection = std::make_shared<Connection>(std::move(socket), *host_);
      MakeRoom();
      const auto answered = std::ranges::count_if(connections_, [](const auto& each) {
        const auto there = each.lock();
        return there && !there->asking();
      });
      const bool full = static_cast<std::size_t>(answered) >= kMaxConnections;
      connections_.push_back(connection);
      full ? connection->StartFull() : connection->Start();
    }
    Accept();
  });
}

// Of those whose requests are not whole the oldest goes, so that they keep nobody out who asks in one piece.
void LiveServer::MakeRoom() {
  std::erase_if(connections_, [](const auto& each) { return each.expired(); });
  std::size_t asking = 0;
  std::shared_ptr<Connection> oldest;
  for (const auto& each : connections_) {
    const auto connection = each.lock();
    if (!connection || !connection->asking()) continue;
    ++asking;
    if (!oldest) oldest = connection;
  }
  if (asking >= kMaxAsking) oldest->End();
}

void LiveServer::Tick() {
  std::erase_if(connections_, [](const auto& each) { return each.expired(); });
  for (const auto& each : connections_)
    if (const auto connection = each.lock()) connection->Tick();
  timer_.expires_after(kTick);
  timer_.async_wait([this](boost::system::error_code wrong) {
    if (!wrong) Tick();
  });
}

void LiveServer::Kick() {
  for (const auto& each : connections_)
    if (const auto connection = each.lock()) connection->Kick();
}

int LiveServer::viewers() const {
  int count = 0;
  for (const auto& each : connections_)
    if (const auto connection = each.lock()) count += connection->viewer();
  return count;
}

void LiveServer::End() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  timer_.cancel();
  for (const auto& each : connections_)
    if (const auto connection = each.lock()) connection->End();
}

}  // namespace kestrel::flight
