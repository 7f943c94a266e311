// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/udp_claim.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>

namespace kestrel::vision {
namespace {

bool IsMulticast(const addrinfo& at) {
  if (at.ai_family == AF_INET)
    return IN_MULTICAST(ntohl(reinterpret_cast<const sockaddr_in*>(at.ai_addr)->sin_addr.s_addr));
  return at.ai_family == AF_INET6 &&
         IN6_IS_ADDR_MULTICAST(&reinterpret_cast<const sockaddr_in6*>(at.ai_addr)->sin6_addr);
}

// Whether anybody listens there now, of whatever program.
int TryToListen(const addrinfo& at) {
  const int probe = socket(at.ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return errno;
  const int error = bind(probe, at.ai_addr, at.ai_addrlen) == 0 ? 0 : errno;
  close(probe);
  return error;
}

// A name of the kernel's that goes with its process: between two programs of Kestrel, of which one is about
// to listen.
int NameOf(const std::string& what, int& error) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // A name that begins with 0 is of no file.
  const std::string name = "kestrel-" + what;
  const std::size_t length = std::min(name.size(), sizeof address.sun_path - 1);
  std::memcpy(address.sun_path + 1, name.data(), length);
  const int held = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  error = held >= 0 && bind(held, reinterpret_cast<sockaddr*>(&address), size) == 0 ? 0 : errno;
  if (error != 0 && held >= 0) close(held);
  return error == 0 ? held : -1;
}

}  // namespace

UdpClaim::~UdpClaim() {
  if (name_ >= 0) close(name_);
}

std::string UdpClaim::Take() {
  const std::lock_guard lock(mutex_);
  if (taken_) return {};
  const std::string what = fmt::format("UDP port {} of {}", port_, host_);
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_DGRAM;
  if (const int error = getaddrinfo(host_.c_str(), std::to_string(port_).c_str(), &hints, &found))
    return fmt::format("{}: {}", what, gai_strerror(error));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> at(found, freeaddrinfo);
  if (!IsMulticast(*at)) {
    int error = 0;
    const int name = NameOf(what, error);
    if (error == 0) error = TryToListen(*at);
    if (error != 0) {
      if (name >= 0) close(name);
      return error == EADDRINUSE ? what + " is in use by another program"
                                 : fmt::format("{}: {}", what, std::strerror(error));
    }
    name_ = name;
  }
  taken_ = true;
  return {};
}

}  // namespace kestrel::vision
