// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace kestrel::flight {

struct LiveServerOptions {
  std::string address = "127.0.0.1";  // as digits; elsewhere than on loopback a token is asked for
  std::uint16_t port = 8765;          // Foxglove's usual one; 0: any that is free
  std::vector<std::string> origins;   // of other pages that may connect
  double frozen_s = 10;               // how long a viewer may take for one message
};

struct LiveOptions {
  LiveServerOptions server;
  bool await_viewer = false;      // the first flight stays at its first frame until somebody sees it
  double speed = 1;               // at the begin (pace.h)
  std::function<double()> now_s;  // any clock that runs in real time; null: the monotonic one
};

}  // namespace kestrel::flight
