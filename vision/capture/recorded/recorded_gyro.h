// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/diagnostics.h"

namespace kestrel::vision {

struct RecordedRate {
  std::int64_t stamp_ns = 0;                      // of the recording's own clock
  Eigen::Vector3d w_I = Eigen::Vector3d::Zero();  // rad/s, in the IMU's axes
};

// Whether a file is an IMU's of EuRoC, whose first line names the stamps and the rates in rad/s, or an MCAP.
bool IsRecordedGyro(const std::filesystem::path& file);

// The gyro of an IMU of EuRoC (imu0/data.csv), or of a topic of sensor_msgs/Imu in an MCAP of ROS 2. topic:
// empty: the only one. A row of the wrong shape, a number that is none, a stamp that repeats or goes back is a
// mistake, with its line or message; with any, there are no samples.
std::vector<RecordedRate> ReadRecordedGyro(const std::filesystem::path& file, const std::string& topic,
                                           Mistakes& mistakes);

}  // namespace kestrel::vision
