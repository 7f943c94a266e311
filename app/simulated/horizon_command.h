// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "app/simulated/image_verb.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel horizon`: attitude from the skyline and heading from the visual compass, of any image or video.
struct HorizonArguments : ImageArguments {
  std::string mask;
  MountAngles mount;
  bool mount_given = false;  // by an option; if not, a lens that looks one way is taken to look ahead
};

CLI::App* AddHorizonCommand(CLI::App& app, HorizonArguments& arguments);

// Prints a line for an image, or writes a row for each frame. Throws InputError with every mistake of the
// arguments and files, and std::runtime_error if reading or writing fails on the way.
void HorizonCommand(const HorizonArguments& arguments);

}  // namespace kestrel::app
