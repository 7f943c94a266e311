// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

// The listening end of a local address: "tcp:PORT" on loopback, or the file of a Unix socket.
namespace kestrel::flight {

struct LocalListener {
  int descriptor = -1;
  std::string where;  // with the port that the system chose
  std::string file;   // of the Unix socket, to be removed; empty: of TCP
};

// A file that nobody listens at any more is replaced. Throws std::runtime_error with the address and the reason.
LocalListener ListenLocally(const std::string& address);

}  // namespace kestrel::flight
