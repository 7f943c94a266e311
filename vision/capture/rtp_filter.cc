// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/rtp_filter.h"

#include <fmt/format.h>
#include <linux/filter.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

namespace kestrel::vision {

std::string TakeRtpOnly(int udp_socket, const RtpPayloads& payloads) {
  // The filter sees UDP's header of eight bytes first; RTP's has twelve (RFC 3550, 5.1), and both payloads'
  // own eight at least (RFC 2435, 3.1; RFC 4175, 4).
  constexpr std::uint32_t kUdp = 8, kLeast = kUdp + 12 + 8;
  const auto least = static_cast<std::uint32_t>(payloads.least);
  const auto most = static_cast<std::uint32_t>(payloads.most);
  std::array<sock_filter, 11> program{{
      BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0),
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, kLeast, 0, 7),
      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kUdp),  // version 2
      BPF_STMT(BPF_ALU | BPF_AND | BPF_K, 0xC0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 0x80, 0, 4),
      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kUdp + 1),  // payload type, after the marker
      BPF_STMT(BPF_ALU | BPF_AND | BPF_K, 0x7F),
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, least, 0, 1),
      BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, most, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, 0),
      BPF_STMT(BPF_RET | BPF_K, 0xFFFFFFFF),
  }};
  const sock_fprog filter{program.size(), program.data()};

  if (setsockopt(udp_socket, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0) return {};
  return fmt::format("the kernel takes no filter for its UDP socket: {}", std::strerror(errno));
}

}  // namespace kestrel::vision
