// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/ros/sensor_messages.h"
#include "vision/camera/camera_model.h"

namespace kestrel::records {

// A calibration as ROS has it, without its header. ROS knows three distortion models, of which pinhole and
// Brown-Conrady are "plumb_bob", Kannala-Brandt is "equidistant" and the rational one "rational_polynomial".
// Others keep their own name, with their parameters in their own order (ParameterNames() behind fx, fy, cx,
// cy) as d.
ros::CameraInfo CameraInfoOf(const vision::CameraModel& camera);

}  // namespace kestrel::records
