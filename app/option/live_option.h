// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "flight/live/live.h"

namespace kestrel::app {

// How a flight is shown while it flies. Absent: it is not.
struct LiveArguments {
  std::optional<std::string> port;  // empty: the usual one
  std::optional<std::string> address, speed;
  std::vector<std::string> origins;
};

// --live, --live-address, --live-origin and, of a flight whose time is the program's own, --live-speed.
void AddLiveOptions(CLI::App& command, LiveArguments& arguments, bool own_time);

// None: it was not asked for, or something is wrong with it.
std::optional<flight::LiveOptions> ReadLive(const LiveArguments& arguments, Mistakes& mistakes);

// Null: it is not to be shown. Throws InputError where that cannot be.
std::unique_ptr<flight::Live> MakeLive(const std::optional<flight::LiveOptions>& options);
// Where viewers find it. Null: nothing.
void PrintLive(const flight::Live* live);
// After the flight: the page stays for those who look at it. Null: it does nothing.
void Linger(flight::Live* live, const std::function<bool()>& go_on);

}  // namespace kestrel::app
