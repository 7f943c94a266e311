// SPDX-License-Identifier: Apache-2.0
#include "flight/live/access.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <random>

namespace kestrel::flight {
namespace {

bool IsAddress(std::string_view host) {
  boost::system::error_code wrong;
  boost::asio::ip::make_address(std::string(host), wrong);
  return !wrong;
}

std::string HostName() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

// What a header names, without its port and the brackets of IPv6.
std::string_view WithoutPort(std::string_view host) {
  const std::size_t bracket = host.find(']');
  if (host.starts_with('[') && bracket != std::string_view::npos) return host.substr(1, bracket - 1);
  const std::size_t colon = host.rfind(':');
  return host.substr(0, colon);
}

// Takes as long for each wrong one, so that its time does not tell how much of it was right.
bool Same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i) differs |= static_cast<unsigned char>(a[i] ^ b[i]);
  return differs == 0;
}

std::string_view TokenOf(std::string_view target) {
  const std::size_t question = target.find('?');
  if (question == std::string_view::npos) return {};
  std::string_view query = target.substr(question + 1);
  while (!query.empty()) {
    const std::size_t end = query.find('&');
    const std::string_view each = query.substr(0, end);
    if (each.starts_with("token=")) return each.substr(6);
    query.remove_prefix(end == std::string_view::npos ? query.size() : end + 1);
  }
  return {};
}

}  // namespace

bool IsLoopback(std::string_view address) {
  boost::system::error_code wrong;
  const auto parsed = boost::asio::ip::make_address(std::string(address), wrong);
  return !wrong && parsed.is_loopback();
}

std::string RandomToken() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

Access::Access(std::string address, std::string token, std::vector<std::string> origins)
    : address_(std::move(address)), token_(std::move(token)), origins_(std::move(origins)) {}

std::string Access::Refusal(const Request& request) const {
  const std::string_view host = WithoutPort(request.host);
  const bool here = IsLoopback(address_);
  const bool known = here ? host == "localhost" || IsLoopback(host)
                          : host == "localhost" || IsAddress(host) || (!host.empty() && host == HostName());
  if (!known) return "this flight is not at that host; open the address that the program printed";
  const bool own = request.origin.empty() || request.origin == fmt::format("http://{}", request.host) ||
                   (request.foxglove && request.origin == "file://");
  if (!own && std::ranges::find(origins_, request.origin) == origins_.end())
    return "a page of another site may not connect; --live-origin names one that may";
  if (!token_.empty() && !Same(TokenOf(request.target), token_))
    return "the token is missing or wrong; open the address that the program printed, with its token";
  return {};
}

}  // namespace kestrel::flight
