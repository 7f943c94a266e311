// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/pose.h"

namespace kestrel::vision {

// X_IC: how the camera of a topic of images stands on the IMU of a topic of sensor_msgs/Imu, by the frames that the
// headers of their first messages name and the transforms (tf2_msgs/TFMessage: /tf_static, /tf) that join them; of each
// frame the first that comes. None: they are not joined. imu_topic: empty: the only one. Throws InputError: no MCAP.
std::optional<Pose> PoseOnImuInMcap(const std::filesystem::path& file, const std::string& image_topic,
                                    const std::string& imu_topic);

}  // namespace kestrel::vision
