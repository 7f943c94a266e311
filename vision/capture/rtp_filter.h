// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kestrel::vision {

// RTP's payload types that are taken.
struct RtpPayloads {
  int least = 0, most = 127;
};

// Has the kernel throw away what comes to a UDP socket and is no RTP of these types, before it is queued.
// Empty: it does; otherwise why not.
std::string TakeRtpOnly(int udp_socket, const RtpPayloads& payloads);

}  // namespace kestrel::vision
