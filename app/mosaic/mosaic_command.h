// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/simulated/image_verb.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel mosaic`: one picture of many images.
struct MosaicArguments : ImageArguments {  // out: the picture; csv: a row for each image
  std::string geotiff, video, poses;
  std::string surface = "plane", compose = "multiband", blend = "feather";
  double fov_deg = 0;  // 0: not given
  double ground_down_m = 0, pose_sigma_m = 1, pose_sigma_deg = 1;
  MountAngles mount;
  double overlap = 0.65;
  bool opencl = false, chain = false, no_exposure = false;
  int memory_mb = 2000, frames = 0, every = 1;
};

CLI::App* AddMosaicCommand(CLI::App& app, MosaicArguments& arguments);

// Throws InputError with every mistake of the arguments and files, and std::runtime_error if reading or writing
// fails on the way. Whether any images were joined, and every file that was asked for is written.
bool MosaicCommand(const MosaicArguments& arguments);

}  // namespace kestrel::app
