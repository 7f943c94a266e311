// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/aircraft.h"

#include <fmt/format.h>

#include <string_view>

#include "base/diagnostics.h"
#include "base/yaml/yaml_fields.h"
#include "control/link/network_address.h"

namespace kestrel::flight {
namespace {

constexpr const char* kForms =
    "mavlink:udp://HOST:PORT, mavlink:udpin://HOST:PORT (listens), mavlink:tcp://HOST:PORT, "
    "afcs:udp://HOST:PORT, "
    "asctec:serial:/dev/ttyUSB0";

std::unique_ptr<control::AutopilotLink> LinkAt(std::string_view protocol, const std::string& where,
                                               const Aircraft& aircraft) {
  if (protocol == "mavlink") return std::make_unique<control::MavlinkLink>(where, aircraft.mavlink);
  if (protocol == "afcs") {
    const control::UdpAddress address = control::ParseUdpAddress(where);
    if (address.listen)
      throw InputError({}, fmt::format("'{}' listens, and an AFCS is called", where),
                       "valid: udp://HOST:PORT");
    control::AfcsLinkOptions options = aircraft.afcs;
    options.host = address.host;
    options.port = address.port;
    return std::make_unique<control::AfcsLink>(options);
  }
  if (protocol == "asctec" && where.starts_with("serial:")) {
    control::AscTecOptions options = aircraft.asctec;
    options.device = where.substr(std::string_view("serial:").size());
    return std::make_unique<control::AscTecLink>(options);
  }
  throw InputError({}, fmt::format("'{}:{}' is no autopilot", protocol, where),
                   fmt::format("valid: {}", kForms));
}

}  // namespace

Aircraft LoadAircraft(const std::string& file, const std::vector<std::string>& overrides,
                      Mistakes& mistakes) {
  Aircraft aircraft;
  const Config config = file.empty() ? ParseConfig("{}", "--aircraft", overrides, mistakes)
                                     : LoadConfig(file, overrides, mistakes);
  Read(config, aircraft, mistakes);
  if (aircraft.safety.thrust_min >= aircraft.safety.thrust_max)
    mistakes.Add(file.empty() ? "--set-aircraft" : file, "safety.thrust_min",
                 fmt::format("{:g} is not below safety.thrust_max = {:g}", aircraft.safety.thrust_min,
                             aircraft.safety.thrust_max));
  return aircraft;
}

std::unique_ptr<control::AutopilotLink> MakeLink(const std::string& address, const Aircraft& aircraft,
                                                 Mistakes& mistakes) {
  const std::size_t colon = address.find(':');
  try {
    if (colon == std::string::npos)
      throw InputError({}, fmt::format("'{}' is no autopilot", address), fmt::format("valid: {}", kForms));
    return LinkAt(std::string_view(address).substr(0, colon), address.substr(colon + 1), aircraft);
  } catch (const InputError& e) {
    mistakes.Add(e, "--autopilot");
    return nullptr;
  }
}

}  // namespace kestrel::flight
