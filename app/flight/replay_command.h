// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/option/live_option.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"

namespace kestrel::app {

struct ReplayArguments {
  std::string folder, video, out;
  std::string scenario, topic, state_topic, csv;  // of an MCAP
  std::optional<int> bits;                        // the same
  std::vector<std::string> overrides;
  LiveArguments live;
  double tolerance = 0;
  bool quiet = false;
};

CLI::App* AddReplayCommand(CLI::App& app, ReplayArguments& arguments);

// Throws InputError where an image is not of the camera's size.
void RequireSizeOf(const vision::CameraModel& camera, const vision::Frame& frame,
                   const std::string& recording);

// Gives the images and states of a recorded flight to its mission again, and tells where what is measured and
// asked for now differs from what it was then. True: nowhere by more than the tolerance. Of an MCAP as
// ReplayLog has it.
// The folder of its --out, if any.
std::optional<std::filesystem::path> OutOf(const ReplayArguments& arguments);

bool ReplayCommand(const ReplayArguments& arguments);

}  // namespace kestrel::app
