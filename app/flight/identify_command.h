// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel identify`: how an aircraft and its autopilot respond, from a flight's log.
struct IdentifyArguments {
  std::filesystem::path log;
};

CLI::App* AddIdentifyCommand(CLI::App& app, IdentifyArguments& arguments);

// Prints each parameter with its deviation, and of those that the log does not tell why. Whether any was found.
// Throws InputError: there is no such file, or it is no log of a kind that is known.
bool IdentifyCommand(const IdentifyArguments& arguments);

}  // namespace kestrel::app
