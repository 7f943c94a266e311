// SPDX-License-Identifier: Apache-2.0
#include "app/flight/recorded_states.h"

#include <algorithm>
#include <cmath>

#include "base/mcap/reader.h"
#include "base/ros/cdr.h"
#include "base/ros/sensor_messages.h"
#include "geometry/ros_frames.h"
#include "vision/capture/recorded/mcap_topic.h"

namespace kestrel::app {
namespace {

Eigen::Vector3d Of(const ros::Vector3& v) { return {v.x, v.y, v.z}; }

// What is wrong with an attitude, or nothing; otherwise sets it.
std::string SetAttitude(const ros::Quaternion& q, control::VehicleState& state) {
  const Eigen::Quaterniond R(q.w, q.x, q.y, q.z);
  constexpr double kNearOne = 0.01;
  if (!(std::abs(R.norm() - 1) < kNearOne)) return "has an orientation that is no rotation";
  state.R_NB = WorldBodyToRos(R.normalized());
  state.R_NB_inertial = state.R_NB;
  return "";
}

std::string StateOf(const ros::Odometry& message, control::VehicleState& state) {
  const std::string wrong = SetAttitude(message.pose.rotation, state);
  state.p_NB = WorldToRos(Of(message.pose.translation));
  state.v_N = state.R_NB * BodyToRos(Of(message.twist.linear));
  state.w_B = BodyToRos(Of(message.twist.angular));
  const bool finite = state.p_NB.allFinite() && state.v_N.allFinite() && state.w_B.allFinite();
  return !wrong.empty() ? wrong : finite ? "" : "has a number that is none";
}

std::string StateOf(const ros::Imu& message, control::VehicleState& state) {
  if (message.orientation_covariance[0] == -1) return "has no orientation";
  state.w_B = BodyToRos(Of(message.angular_velocity));
  if (!state.w_B.allFinite()) return "has a rate that is no number";
  return SetAttitude(message.orientation, state);
}

}  // namespace

RecordedStates ReadRecordedStates(const std::filesystem::path& file, const std::string& topic,
                                  Mistakes& mistakes) {
  RecordedStates recorded;
  mcap::Reader reader(file);
  const auto odometry = vision::TopicsOf(reader, {ros::Odometry::kType});
  const bool of_imu = odometry.empty() || (!topic.empty() && std::find(odometry.begin(), odometry.end(),
                                                                       topic) == odometry.end());
  const std::vector<std::string> types =
      odometry.empty() ? std::vector<std::string>{ros::Imu::kType}
      : topic.empty()  ? std::vector<std::string>{ros::Odometry::kType}
                       : std::vector<std::string>{ros::Odometry::kType, ros::Imu::kType};
  const auto found = vision::TopicOf(reader, file, topic, types, "states", mistakes);
  if (!found) return recorded;
  recorded.topic = *found, recorded.placed = !of_imu;
  vision::McapStamps stamps(file, *found, mistakes);
  reader.Select({*found});
  while (const auto message = reader.Next()) {
    stamps.Add(*message);
    control::VehicleState& state = recorded.states.emplace_back();
    state.mode = control::FlightMode::kVelocity, state.landed = false;
    try {
      const std::string wrong = of_imu ? StateOf(ros::FromCdr<ros::Imu>(message->data), state)
                                       : StateOf(ros::FromCdr<ros::Odometry>(message->data), state);
      if (!wrong.empty()) stamps.Wrong(wrong);
    } catch (const ros::CdrError& e) {
      stamps.Wrong(e.what());
    }
  }
  recorded.stamps_ns = stamps.Take();
  recorded.logged_ns = stamps.logged_ns();
  if (recorded.states.empty()) mistakes.Add(file.string(), "topic", *found + " has no messages");
  return recorded;
}

}  // namespace kestrel::app
