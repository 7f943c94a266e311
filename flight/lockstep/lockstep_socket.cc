// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/lockstep_socket.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "flight/lockstep/lockstep_server.h"

namespace kestrel::flight {
namespace {

constexpr int kWaiting = 16;  // connections that the system keeps until they are taken
constexpr char kTcp[] = "tcp:";

std::optional<int> PortOf(const std::string& address) {
  int port = -1;
  const char *begin = address.data() + std::strlen(kTcp), *end = address.data() + address.size();
  const auto read = std::from_chars(begin, end, port);
  if (read.ec != std::errc{} || read.ptr != end || port < 0 || port > 65535) return std::nullopt;
  return port;
}

// Closed with this object unless it is taken.
struct Socket {
  Socket(int family, const std::string& where)
      : descriptor(socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0)), address(where) {
    if (descriptor < 0) Fail();
  }
  ~Socket() {
    if (descriptor >= 0) close(descriptor);
  }
  [[noreturn]] void Fail() const { Fail(std::strerror(errno)); }
  [[noreturn]] void Fail(const std::string& reason) const {
    throw std::runtime_error(fmt::format("cannot listen at {}: {}", address, reason));
  }
  int Take() { return std::exchange(descriptor, -1); }
  int descriptor;
  std::string address;
};

LocalListener ListenByTcp(const std::string& address) {
  Socket tcp(AF_INET, address);
  const int yes = 1;
  setsockopt(tcp.descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(*PortOf(address)));
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof here;
  if (bind(tcp.descriptor, reinterpret_cast<sockaddr*>(&here), size) != 0 ||
      listen(tcp.descriptor, kWaiting) != 0 ||
      getsockname(tcp.descriptor, reinterpret_cast<sockaddr*>(&here), &size) != 0)
    tcp.Fail();
  return {tcp.Take(), fmt::format("tcp:{}", ntohs(here.sin_port)), {}};
}

LocalListener ListenAtFile(const std::string& file) {
  sockaddr_un here{};
  here.sun_family = AF_UNIX;
  std::memcpy(here.sun_path, file.data(), file.size());
  auto* const at = reinterpret_cast<sockaddr*>(&here);
  Socket local(AF_UNIX, file);
  struct stat there {};
  if (lstat(file.c_str(), &there) == 0) {
    if (!S_ISSOCK(there.st_mode)) local.Fail("a file that is no socket has that name");
    const Socket probe(AF_UNIX, file);
    if (connect(probe.descriptor, at, sizeof here) == 0) local.Fail("another server listens there");
    if (errno != ECONNREFUSED) local.Fail();
    unlink(file.c_str());  // of a server that was killed
  }
  // For this user alone, from the first moment.
  if (fchmod(local.descriptor, 0600) != 0 || bind(local.descriptor, at, sizeof here) != 0 ||
      listen(local.descriptor, kWaiting) != 0)
    local.Fail();
  return {local.Take(), file, file};
}

}  // namespace

std::string DefaultLockstepAddress() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime && *runtime) return std::string(runtime) + "/kestrel.sock";
  return fmt::format("/tmp/kestrel-{}.sock", getuid());
}

std::string LockstepAddressMistake(const std::string& address) {
  if (address.starts_with(kTcp)) return PortOf(address) ? "" : fmt::format("'{}' has no port", address);
  if (address.size() >= sizeof(sockaddr_un::sun_path))
    return fmt::format("'{}' is longer than a Unix socket's name may be: {} bytes", address,
                       sizeof(sockaddr_un::sun_path) - 1);
  return "";
}

LocalListener ListenLocally(const std::string& address) {
  return address.starts_with(kTcp) ? ListenByTcp(address) : ListenAtFile(address);
}

}  // namespace kestrel::flight
