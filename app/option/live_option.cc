// SPDX-License-Identifier: Apache-2.0
#include "app/option/live_option.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <cstdio>

#include "flight/live/pace.h"

namespace kestrel::app {
namespace {

template <class Number>
std::optional<Number> Read(const std::string& text) {
  Number number{};
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec != std::errc{} || end.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

constexpr char kAsFast[] = "max";

}  // namespace

void AddLiveOptions(CLI::App& command, LiveArguments& a, bool own_time) {
  command
      .add_option(
          "--live", a.port,
          "Show the flight while it flies, to browsers and to Foxglove: at this port of this computer, "
          "8765 if none is given, 0 for any that is free (docs/guide/live.md)")
      ->expected(0, 1)
      ->type_name("PORT");
  command
      .add_option("--live-address", a.address,
                  "Where that listens, instead of 127.0.0.1: 0.0.0.0 for the whole network, by a token then")
      ->type_name("ADDRESS");
  command
      .add_option(
          "--live-origin", a.origins,
          "A web page elsewhere that may watch too, such as https://app.foxglove.dev; may be repeated")
      ->type_name("URL")
      ->allow_extra_args(false);
  if (own_time)
    command
        .add_option("--live-speed", a.speed,
                    "How fast it begins, as a multiple of real time, from 0.1 to 100, or max; 1 if not given")
        ->type_name("SPEED");
}

std::optional<flight::LiveOptions> ReadLive(const LiveArguments& a, Mistakes& mistakes) {
  if (!a.port) {
    for (const auto& [option, given] : {std::pair{"--live-address", a.address.has_value()},
                                        {"--live-origin", !a.origins.empty()},
                                        {"--live-speed", a.speed.has_value()}})
      if (given) mistakes.Add(option, "", "given without --live");
    return std::nullopt;
  }
  flight::LiveOptions options;
  const std::size_t before = mistakes.all().size();
  if (!a.port->empty()) {
    const auto port = Read<std::uint16_t>(*a.port);
    if (!port)
      mistakes.Add("--live", "", fmt::format("'{}' is no port", *a.port),
                   "valid: from 1 to 65535, or 0 for any that is free; the scenario comes before --live");
    options.server.port = port.value_or(0);
  }
  if (a.address) options.server.address = *a.address;
  options.server.origins = a.origins;
  for (const std::string& origin : a.origins)
    if (!(origin.starts_with("http://") || origin.starts_with("https://")) ||
        origin.find_first_of("/ *", origin.find("//") + 2) != std::string::npos || origin.ends_with("//"))
      mistakes.Add(
          "--live-origin", "", fmt::format("'{}' is no origin of web pages", origin),
          "valid: a scheme and a host, with a port where it has one, such as https://app.foxglove.dev");
  if (a.speed == kAsFast) {
    options.speed = flight::Pace::kAsFast;
  } else if (a.speed) {
    const auto speed = Read<double>(*a.speed);
    if (speed && *speed != flight::Pace::kAsFast && flight::Pace::Valid(*speed))
      options.speed = *speed;
    else
      mistakes.Add("--live-speed", "", fmt::format("'{}' is no speed", *a.speed),
                   fmt::format("valid: from {:g} to {:g} times real time, or {}", flight::Pace::kLeast,
                               flight::Pace::kMost, kAsFast));
  }
  if (mistakes.all().size() > before) return std::nullopt;
  return options;
}

std::unique_ptr<flight::Live> MakeLive(const std::optional<flight::LiveOptions>& options) {
  return options ? std::make_unique<flight::Live>(*options) : nullptr;
}

void PrintLive(const flight::Live* live) {
  if (!live) return;
  fmt::print("  live  {}\n", live->url());
  if (live->open_to_others())
    fmt::print(
        "        it is open to the network, uncoded: whoever reads this address sees the flight, and of a "
        "simulated one changes what its scenario lets change\n");
  std::fflush(stdout);
}

void Linger(flight::Live* live, const std::function<bool()>& go_on) {
  if (!live || live->viewers() == 0 || !go_on()) return;
  fmt::print("  live  {}: until its pages are closed, or Ctrl-C\n", live->url());
  std::fflush(stdout);
  live->Linger(go_on);
}

}  // namespace kestrel::app
