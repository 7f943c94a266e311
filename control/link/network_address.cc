// SPDX-License-Identifier: Apache-2.0
#include "control/link/network_address.h"

#include <charconv>
#include <string_view>

#include "base/diagnostics.h"

namespace kestrel::control {
namespace {

constexpr std::string_view kTo = "udp://", kIn = "udpin://", kTcp = "tcp://";
constexpr char kUdpForms[] = "udp://HOST:PORT or udpin://HOST:PORT", kTcpForms[] = "tcp://HOST:PORT";

[[noreturn]] void Refuse(const std::string& text, const char* what, const char* forms) {
  throw InputError({}, "address \"" + text + "\": " + what + " (" + forms + ")");
}

struct HostAndPort {
  std::string host;  // without brackets
  std::uint16_t port = 0;
};

// rest: what of the text comes after its scheme.
HostAndPort Split(const std::string& text, std::string_view rest, const char* forms) {
  HostAndPort split;
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string_view::npos) Refuse(text, "no port", forms);
  std::string_view host = rest.substr(0, colon);
  const std::string_view port = rest.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), split.port);
  if (error != std::errc{} || end != port.data() + port.size())
    Refuse(text, "the port is no number to 65535", forms);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    Refuse(text, "colons in the host without brackets", forms);
  }
  split.host = host;
  return split;
}

std::string Bracketed(const std::string& host) {
  return host.find(':') != std::string::npos ? '[' + host + ']' : host;
}

}  // namespace

UdpAddress ParseUdpAddress(const std::string& text) {
  const bool listen = text.starts_with(kIn);
  if (!listen && !text.starts_with(kTo))
    Refuse(text, "begins otherwise", text.starts_with("tcp:") ? kTcpForms : kUdpForms);
  const auto [host, port] =
      Split(text, std::string_view(text).substr((listen ? kIn : kTo).size()), kUdpForms);
  if (port == 0 && !listen) Refuse(text, "port 0 cannot be sent to", kUdpForms);
  if (host.empty() && !listen) Refuse(text, "no host", kUdpForms);
  return {listen, host.empty() ? "127.0.0.1" : host, port};
}

TcpAddress ParseTcpAddress(const std::string& text) {
  if (!IsTcp(text)) Refuse(text, "begins otherwise", kTcpForms);
  const auto [host, port] = Split(text, std::string_view(text).substr(kTcp.size()), kTcpForms);
  if (port == 0) Refuse(text, "port 0 cannot be connected to", kTcpForms);
  if (host.empty()) Refuse(text, "no host", kTcpForms);
  return {host, port};
}

bool IsTcp(const std::string& text) { return text.starts_with(kTcp); }

std::string ToText(const UdpAddress& address) {
  return std::string(address.listen ? kIn : kTo) + Bracketed(address.host) + ':' +
         std::to_string(address.port);
}

std::string ToText(const TcpAddress& address) {
  return std::string(kTcp) + Bracketed(address.host) + ':' + std::to_string(address.port);
}

}  // namespace kestrel::control
