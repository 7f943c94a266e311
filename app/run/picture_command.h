// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel picture`: an instant of a flight, seen from outside, at high quality.
struct PictureArguments {
  std::string scenario, out, view = "chase";
  std::optional<std::string> size;
  double at_s = 0;
  std::vector<std::string> overrides;
  std::string seed;
  bool quiet = false;
};

CLI::App* AddPictureCommand(CLI::App& app, PictureArguments& arguments);

// Throws InputError, also where the flight ends before that instant; std::runtime_error.
void PictureCommand(const PictureArguments& arguments);

}  // namespace kestrel::app
