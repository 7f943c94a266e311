// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>

#include "app/stabilise/stabilise_command.h"
#include "base/diagnostics.h"
#include "vision/camera/camera_model.h"
#include "vision/enhance/stabilisation/gyro_track.h"

namespace kestrel::app {

struct Gyro {
  vision::GyroTrack track;
  double offset_s = 0;  // to be added to the video's time for the gyro's
};

// The gyro of --imu and its clock, whose offset is estimated from the video and told unless it is given, or the
// gyro's stamps are of the clock of the images'. Rates in the axes of an IMU are turned into the camera's by the
// calibration. None: a mistake says why it is no file of a gyro, or has nothing to do with the video.
std::optional<Gyro> OpenGyro(const StabiliseArguments& arguments, const vision::CameraModel& camera,
                             const ImageInput& input, const std::atomic<bool>& stopped, Mistakes& mistakes);

}  // namespace kestrel::app
