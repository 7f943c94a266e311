// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/simulated/image_verb.h"
#include "vision/enhance/stabilisation/stabiliser_options.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel stabilise`: a video whose view stands still or goes smoothly.
struct StabiliseArguments : ImageArguments {  // out: the video; csv: a row for each image
  vision::StabiliserOptions options;
  std::string imu, imu_topic, before_after, level = "none";
  MountAngles mount{.pitch_deg = 90};  // a horizon is seen by a camera that looks ahead
  std::optional<double> imu_offset_s;  // none: it is estimated
  double readout_s = 0, max_offset_s = 2;
  int frames = 0;
  bool no_scale = false, unbounded = false;
};

CLI::App* AddStabiliseCommand(CLI::App& app, StabiliseArguments& arguments);

// Whether the motion of an image was measured and, if it was asked for, a horizon seen. Throws InputError with every
// mistake of the arguments and files, and std::runtime_error if reading or writing fails on the way; then what was
// stabilised until then has been written.
bool StabiliseCommand(const StabiliseArguments& arguments);

}  // namespace kestrel::app
