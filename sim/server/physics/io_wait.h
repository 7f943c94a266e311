// SPDX-License-Identifier: Apache-2.0
#pragma once

// clang-format off
#include <utility>  // Asio of Boost 1.74 needs it and does not include it
// clang-format on

// For .cc files alone: Boost.Asio is slow to compile.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/asio.hpp>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>

namespace kestrel::sim {

// Runs the handlers of a socket on the thread that waits for what they bring.
class IoWait {
 public:
  explicit IoWait(boost::asio::io_context& io) : io_(io), work_(boost::asio::make_work_guard(io)) {}

  // Until done() is true, true; until the deadline or Stop(), false.
  template <class Done>
  bool Until(Done done, std::optional<std::chrono::steady_clock::time_point> deadline = {}) {
    io_.poll();
    while (!done()) {
      const auto now = std::chrono::steady_clock::now();
      if (stopped() || (deadline && now >= *deadline)) return false;
      const auto look = now + std::chrono::milliseconds(20);  // for Stop()
      io_.run_one_until(deadline ? std::min(*deadline, look) : look);
    }
    return true;
  }

  void Stop() { stop_ = true; }
  bool stopped() const { return stop_; }

 private:
  boost::asio::io_context& io_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  std::atomic<bool> stop_ = false;
  static_assert(std::atomic<bool>::is_always_lock_free);
};

inline boost::asio::ip::address ParseAddress(const std::string& text) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(text, error);
  if (error) throw std::runtime_error(fmt::format("{}: not an IP address", text));
  return address;
}

// open: throws what Asio does.
template <class Endpoint, class Open>
void Listen(const char* protocol, const Endpoint& here, Open open) {
  try {
    open();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error(fmt::format("cannot listen on {}://{}:{}: {}", protocol,
                                         here.address().to_string(), here.port(), error.code().message()));
  }
}

}  // namespace kestrel::sim
