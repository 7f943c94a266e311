// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/ros/annotations.h"
#include "base/ros/messages.h"
#include "mission/log_row.h"
#include "vision/camera/camera_model.h"

// What a row of a flight's log is in ROS's messages and frames (geometry/ros_frames.h). Frames: "map" is N,
// "base_link" B, "heading" B turned level, "pad" the pad's, "camera_NAME" a camera's.
namespace kestrel::records {

inline constexpr char kMapFrame[] = "map", kBodyFrame[] = "base_link", kHeadingFrame[] = "heading",
                      kPadFrame[] = "pad";

ros::Header HeaderOf(double t_s, const char* frame);
ros::Transform TransformOf(const Pose& X);  // as it is

// Of the aircraft in the map; its twist in its own axes.
ros::Odometry TruthMessage(const Truth& truth);
ros::Odometry EstimateMessage(const control::VehicleState& state);

// The aircraft and its camera, the pad and others in the air, at an exposure.
ros::TfMessage TfMessageOf(const Truth& exposure, const std::string& camera_frame);

// The aircraft in the pad's frame: by the camera at the exposure, with its yaw alone; and where it is meant
// to be.
std::optional<ros::PoseStamped> FixMessage(const mission::LogRow& row);
std::optional<ros::PoseStamped> GoalMessage(const mission::LogRow& row);

// A velocity is in the heading frame; of an attitude the yaw is that of the estimate.
using SetpointMessage = std::variant<ros::TwistStamped, ros::PoseStamped, ros::AttitudeTarget>;
SetpointMessage SetpointMessageOf(const control::Setpoint& setpoint, const control::VehicleState& state);

ros::Vector3Stamped WindMessage(const Truth& truth);

// The pad's outline where the fix has it, with roll and pitch of the estimate, and what the mission says of
// its target. outline: in the pad's plane, m; empty: there is no pad.
ros::ImageAnnotations DrawnMessage(const mission::LogRow& row, const std::vector<Eigen::Vector2d>& outline,
                                   const vision::CameraModel& camera, const Pose& X_BC);

}  // namespace kestrel::records
