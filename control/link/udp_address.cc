// SPDX-License-Identifier: Apache-2.0
#include "control/link/udp_address.h"

#include <charconv>
#include <string_view>

#include "base/diagnostics.h"

namespace kestrel::control {
namespace {

constexpr std::string_view kTo = "udp://", kIn = "udpin://";

[[noreturn]] void Refuse(const std::string& text, const char* what) {
  throw InputError({}, "address \"" + text + "\": " + what + " (udp://HOST:PORT or udpin://HOST:PORT)");
}

}  // namespace

UdpAddress ParseUdpAddress(const std::string& text) {
  UdpAddress address;
  std::string_view rest = text;
  if (rest.starts_with(kTo)) {
    rest.remove_prefix(kTo.size());
  } else if (rest.starts_with(kIn)) {
    rest.remove_prefix(kIn.size());
    address.listen = true;
  } else {
    Refuse(text, "begins otherwise");
  }
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string_view::npos) Refuse(text, "no port");
  std::string_view host = rest.substr(0, colon);
  const std::string_view port = rest.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (error != std::errc{} || end != port.data() + port.size())
    Refuse(text, "the port is no number to 65535");
  if (address.port == 0 && !address.listen) Refuse(text, "port 0 cannot be sent to");
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    Refuse(text, "colons in the host without brackets");
  }
  if (host.empty() && !address.listen) Refuse(text, "no host");
  address.host = host.empty() ? "127.0.0.1" : std::string(host);
  return address;
}

std::string ToText(const UdpAddress& address) {
  const bool version6 = address.host.find(':') != std::string::npos;
  return std::string(address.listen ? kIn : kTo) + (version6 ? '[' + address.host + ']' : address.host) +
         ':' + std::to_string(address.port);
}

}  // namespace kestrel::control
