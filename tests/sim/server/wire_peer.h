// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "control/wire/bytes.h"

namespace kestrel::sim {

// The other end of a server's socket on this computer, by the operating system's own calls. Whoever waits in
// vain for half a minute is told so: nothing hangs.
class WirePeer {
 public:
  static constexpr int kPatience_ms = 30000;

  // where: "tcp://127.0.0.1:4560", "udp://127.0.0.1:9002"
  explicit WirePeer(const std::string& where) {
    const bool tcp = where.starts_with("tcp");
    fd_ = ::socket(AF_INET, tcp ? SOCK_STREAM : SOCK_DGRAM, 0);
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    there.sin_port = htons(static_cast<std::uint16_t>(std::atoi(where.c_str() + where.rfind(':') + 1)));
    connected_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0;
  }
  ~WirePeer() { ::close(fd_); }
  WirePeer(const WirePeer&) = delete;
  WirePeer& operator=(const WirePeer&) = delete;

  bool connected() const { return connected_; }
  bool Send(std::span<const std::uint8_t> bytes) const {
    return ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  bool Readable(int within_ms) const {
    pollfd wait{fd_, POLLIN, 0};
    return ::poll(&wait, 1, within_ms) == 1;
  }
  // What is there, after waiting for something. Empty: the other end is closed, or patience.
  control::wire::Bytes Receive() const {
    control::wire::Bytes bytes(4096);
    const ssize_t size = Readable(kPatience_ms) ? ::recv(fd_, bytes.data(), bytes.size(), 0) : 0;
    bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return bytes;
  }

 private:
  int fd_ = -1;
  bool connected_ = false;
};

}  // namespace kestrel::sim
