// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel mirror`: designs a hyperbolic mirror for one viewpoint, thesis 6.2.1. The defaults are the
// thesis's.
struct MirrorArguments {
  double rim_mm = 20, ratio = 2;                      // ratio: a / b
  std::optional<double> height_mm, rim_px, focal_mm;  // any two make the third, eq. (6.11)
  int width_px = 640, height_px = 480;
  double pixel_um = 10;
  std::string drawing = "mirror.png", camera;  // files; empty: not written
};

CLI::App* AddMirrorCommand(CLI::App& app, MirrorArguments& arguments);

// Prints the design and writes what is asked for. Throws InputError with every reason why there is no such
// mirror.
void MirrorCommand(const MirrorArguments& arguments);

}  // namespace kestrel::app
