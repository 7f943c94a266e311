// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace kestrel::sim {

// What a line does to each datagram, in both directions.
struct LineFaults {
  bool cut = false;      // nothing passes, and what is under way is lost
  double lost = 0;       // shares
  double doubled = 0;    // the second comes with a delay of its own
  double delay_s = 0;    // of every one
  double scatter_s = 0;  // and up to so much more, by chance: where it is more than what lies between two,
                         // they come in another order
};

struct LineCounts {
  std::int64_t passed = 0, lost = 0, doubled = 0, overtaken = 0;  // overtaken: by one that was sent later
};

// A line between a client and a server of UDP on this computer that fails as it is told to: it listens on the
// loopback address, hands on to the server what the last sender says, and to him what the server says. A
// thread of its own; all may be called from any other.
class UdpRelay {
 public:
  // Throws std::system_error: no socket can be had.
  UdpRelay(const std::string& to_address, int to_port, std::uint64_t seed);
  ~UdpRelay();
  UdpRelay(const UdpRelay&) = delete;
  UdpRelay& operator=(const UdpRelay&) = delete;

  int port() const;  // at which it listens
  void Set(const LineFaults& faults);
  LineCounts counts() const;

 private:
  struct Line;
  std::unique_ptr<Line> line_;
};

}  // namespace kestrel::sim
