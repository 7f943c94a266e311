// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel view`: another picture of what a wide camera took, of an image or a video file. An empty text and
// an absent number are options that were not given.
struct ViewArguments {
  std::string input, camera, camera_name, as = "perspective", out;
  std::string size, azimuth_deg, elevation_deg, alpha_deg, radius_px;
  std::optional<double> yaw_deg, pitch_deg, roll_deg, fov_deg;
  std::optional<int> bits;  // of 16-bit pixels
  bool quiet = false;
};

// The verb with its options.
CLI::App* AddViewCommand(CLI::App& app, ViewArguments& arguments);

// Writes the file. Throws InputError with every mistake of the arguments and files, and std::runtime_error if
// reading or writing fails on the way.
void ViewCommand(const ViewArguments& arguments);

}  // namespace kestrel::app
