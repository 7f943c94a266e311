// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <utility>

namespace kestrel::vision {

// This process's claim on an address at which a pipeline of GStreamer listens. Such a pipeline lets others
// listen there too, so that one that hangs can be replaced; of several, the last has all that comes, and
// another program would take the images of an aircraft that flies.
//
// It holds until the object goes, or the process. Addresses of multicast, where each listener has its own
// copy, are not claimed.
class UdpClaim {
 public:
  UdpClaim(std::string host, std::uint16_t port) : host_(std::move(host)), port_(port) {}
  ~UdpClaim();
  UdpClaim(const UdpClaim&) = delete;
  UdpClaim& operator=(const UdpClaim&) = delete;

  // Once taken it stays so. Empty: it is ours. Otherwise why not. From any thread.
  std::string Take();

 private:
  const std::string host_;
  const std::uint16_t port_;
  std::mutex mutex_;
  bool taken_ = false;
  int name_ = -1;
};

}  // namespace kestrel::vision
