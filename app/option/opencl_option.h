// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace kestrel::app {

// --opencl of a command that follows points from image to image.
inline void AddOpenClOption(CLI::App& command, bool& opencl) {
  command.add_flag("--opencl", opencl,
                   "Follow points on a device of OpenCL (OPENCV_OPENCL_DEVICE chooses it); without one the "
                   "processor does, and that is told");
}

}  // namespace kestrel::app
