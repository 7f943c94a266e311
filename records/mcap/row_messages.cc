// SPDX-License-Identifier: Apache-2.0
#include "records/mcap/row_messages.h"

#include <fmt/format.h>

#include "base/nanoseconds.h"
#include "base/overloaded.h"
#include "geometry/ros_frames.h"
#include "geometry/tait_bryan.h"

namespace kestrel::records {
namespace {

ros::Vector3 Vector3Of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
ros::Quaternion QuaternionOf(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

ros::Odometry OdometryOf(double t_s, const Pose& X_NB, const Eigen::Vector3d& v_N,
                         const Eigen::Vector3d& w_B) {
  ros::Odometry odometry;
  odometry.header = HeaderOf(t_s, kMapFrame);
  odometry.child_frame_id = kBodyFrame;
  odometry.pose = TransformOf(WorldBodyToRos(X_NB));
  odometry.twist.linear = Vector3Of(BodyToRos(X_NB.R.conjugate() * v_N));
  odometry.twist.angular = Vector3Of(BodyToRos(w_B));
  return odometry;
}

ros::PoseStamped InPad(double t_s, const Eigen::Vector3d& p_TB, double yaw_TB) {
  return {HeaderOf(t_s, kPadFrame), TransformOf(BodyBodyToRos(Pose{HeadingRotation(yaw_TB), p_TB}))};
}

constexpr ros::Colour kSeen{0.3, 1, 0.3, 1};
constexpr int kPointsOfAnEdge = 8;  // a lens bends it

// What lies in view, closed where all of it does.
void AddOutline(const std::vector<Eigen::Vector2d>& outline, const vision::CameraModel& camera,
                const Pose& X_CT, ros::PointsAnnotation& drawn) {
  drawn.type = ros::PointsAnnotation::kLineLoop;
  for (std::size_t i = 0; i < outline.size(); ++i)
    for (int part = 0; part < kPointsOfAnEdge; ++part) {
      const double share = static_cast<double>(part) / kPointsOfAnEdge;
      const Eigen::Vector2d at = outline[i] + share * (outline[(i + 1) % outline.size()] - outline[i]);
      const auto uv = vision::Project(camera, X_CT * Eigen::Vector3d(at.x(), at.y(), 0));
      if (!uv)
        drawn.type = ros::PointsAnnotation::kLineStrip;
      else
        drawn.points.push_back({uv->x() + 0.5, uv->y() + 0.5});
    }
}

}  // namespace

ros::Header HeaderOf(double t_s, const char* frame) { return {ros::TimeOf(Nanoseconds(t_s)), frame}; }

ros::Transform TransformOf(const Pose& X) { return {Vector3Of(X.p), QuaternionOf(X.R)}; }

ros::Odometry TruthMessage(const Truth& truth) {
  return OdometryOf(truth.t_s, truth.X_NB, truth.v_N, truth.w_B);
}

ros::Odometry EstimateMessage(const control::VehicleState& state) {
  return OdometryOf(state.t_s, {state.R_NB, state.p_NB}, state.v_N, state.w_B);
}

ros::TfMessage TfMessageOf(const Truth& exposure, const std::string& camera_frame) {
  ros::TfMessage tf;
  const auto add = [&](const char* frame, const std::string& child, const Pose& X) {
    tf.transforms.push_back({HeaderOf(exposure.t_s, frame), child, TransformOf(X)});
  };
  add(kMapFrame, kBodyFrame, WorldBodyToRos(exposure.X_NB));
  add(kBodyFrame, camera_frame, BodyCameraToRos(exposure.X_NB.Inverse() * exposure.X_NC));
  add(kMapFrame, kPadFrame, WorldBodyToRos(exposure.X_NT));
  for (std::size_t i = 0; i < exposure.targets.size(); ++i)
    add(kMapFrame, fmt::format("target_{}", i),
        {Eigen::Quaterniond::Identity(), WorldToRos(exposure.targets[i].p_N)});
  return tf;
}

std::optional<ros::PoseStamped> FixMessage(const mission::LogRow& row) {
  if (!row.decision.fix) return std::nullopt;
  return InPad(row.exposure.t_s, row.decision.fix->p_TB, row.decision.fix->yaw_TB);
}

std::optional<ros::PoseStamped> GoalMessage(const mission::LogRow& row) {
  if (!row.decision.goal_T) return std::nullopt;
  return InPad(row.now.t_s, *row.decision.goal_T, row.decision.goal_yaw_TB);
}

SetpointMessage SetpointMessageOf(const control::Setpoint& setpoint, const control::VehicleState& state) {
  using Target = ros::AttitudeTarget;
  return std::visit(
      Overloaded{[&](const control::VelocitySetpoint& s) -> SetpointMessage {
                   return ros::TwistStamped{HeaderOf(state.t_s, kHeadingFrame),
                                            {Vector3Of(BodyToRos(s.v_H)), {0, 0, -s.yaw_rate}}};
                 },
                 [&](const control::PositionSetpoint& s) -> SetpointMessage {
                   return ros::PoseStamped{HeaderOf(state.t_s, kMapFrame),
                                           TransformOf(WorldBodyToRos(Pose{HeadingRotation(s.yaw), s.p_N}))};
                 },
                 [&](const control::AttitudeSetpoint& s) -> SetpointMessage {
                   const Eigen::Quaterniond R_NB(RotationFromTaitBryan({YawOf(state.R_NB), s.pitch, s.roll}));
                   return Target{HeaderOf(state.t_s, kMapFrame),
                                 Target::kIgnoreRollRate | Target::kIgnorePitchRate,
                                 QuaternionOf(WorldBodyToRos(R_NB)), Vector3Of({0, 0, -s.yaw_rate}),
                                 static_cast<float>(s.thrust)};
                 },
                 [&](const control::RateSetpoint& s) -> SetpointMessage {
                   return Target{HeaderOf(state.t_s, kBodyFrame),
                                 Target::kIgnoreAttitude,
                                 {},
                                 Vector3Of(BodyToRos(s.w_B)),
                                 static_cast<float>(s.thrust)};
                 }},
      setpoint);
}

ros::Vector3Stamped WindMessage(const Truth& truth) {
  return {HeaderOf(truth.t_s, kMapFrame), Vector3Of(WorldToRos(truth.wind_N))};
}

ros::ImageAnnotations DrawnMessage(const mission::LogRow& row, const std::vector<Eigen::Vector2d>& outline,
                                   const vision::CameraModel& camera, const Pose& X_BC) {
  ros::ImageAnnotations drawn;
  const ros::Time stamp = HeaderOf(row.exposure.t_s, "").stamp;
  const mission::Decision& decision = row.decision;
  drawn.texts.push_back(
      {stamp, {6, 18}, fmt::format("{} {}", decision.phase, decision.target), 14, kSeen, {0, 0, 0, 0.4}});
  if (decision.fix && !outline.empty()) {
    const Eigen::Quaterniond tilt = HeadingRotation(YawOf(row.estimate.R_NB)).conjugate() * row.estimate.R_NB;
    const Pose X_TB{HeadingRotation(decision.fix->yaw_TB) * tilt, decision.fix->p_TB};
    ros::PointsAnnotation pad;
    pad.timestamp = stamp;
    pad.outline_color = kSeen;
    pad.thickness = 2;
    AddOutline(outline, camera, (X_TB * X_BC).Inverse(), pad);
    drawn.points.push_back(pad);
  }
  return drawn;
}

}  // namespace kestrel::records
