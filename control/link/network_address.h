// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace kestrel::control {

// "udp://HOST:PORT": send to it. "udpin://HOST:PORT": listen there for whoever sends first; HOST is an
// address of this computer, 0.0.0.0 for all of them, and left out the loopback address. An address of version
// 6 stands in brackets.
struct UdpAddress {
  bool listen = false;
  std::string host;
  std::uint16_t port = 0;  // 0 only to listen: the system chooses
};

// "tcp://HOST:PORT": a server to connect to.
struct TcpAddress {
  std::string host;
  std::uint16_t port = 0;
};

// Both throw InputError.
UdpAddress ParseUdpAddress(const std::string& text);
TcpAddress ParseTcpAddress(const std::string& text);
bool IsTcp(const std::string& text);  // it begins so

std::string ToText(const UdpAddress& address);
std::string ToText(const TcpAddress& address);

}  // namespace kestrel::control
