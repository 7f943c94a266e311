// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>

#include "app/stabilise/gyro_input.h"
#include "app/stabilise/stabilise_command.h"
#include "vision/camera/camera_model.h"

namespace kestrel::app {

// Every image of the input, written as it is stabilised, and whether what was asked for came of it, as of
// StabiliseCommand(). Throws std::runtime_error if reading or writing fails on the
// way; what was stabilised until then has been written.
bool StabiliseVideo(const StabiliseArguments& arguments, ImageInput& input,
                    const std::optional<vision::CameraModel>& camera, const std::optional<Gyro>& gyro,
                    const std::atomic<bool>& stopped);

}  // namespace kestrel::app
