// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "control/autopilot.h"

namespace kestrel::app {

// The states of an aircraft in an MCAP of ROS 2, in our frames (geometry/ros_frames.h).
struct RecordedStates {
  std::string topic;
  bool placed = false;                        // whether they have position and velocity; an IMU has none
  std::vector<std::int64_t> stamps_ns;        // of the headers, going up
  std::vector<std::int64_t> logged_ns;        // when each was logged
  std::vector<control::VehicleState> states;  // t_s is not set
};

// Of a topic of nav_msgs/Odometry or, where there is none, the orientation and rates of sensor_msgs/Imu. topic: empty:
// the only one of its type. What is wrong is a mistake: no such topic, several, an IMU without orientation, a
// quaternion that is none, a stamp that repeats or goes back.
RecordedStates ReadRecordedStates(const std::filesystem::path& file, const std::string& topic,
                                  Mistakes& mistakes);

}  // namespace kestrel::app
