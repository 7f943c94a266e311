// SPDX-License-Identifier: Apache-2.0
#include "control/wire/mavlink_sightings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tait_bryan.h"

namespace kestrel::control::wire::mavlink {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::uint8_t kLocalFrd = 20, kBody = 12;  // MAV_FRAME
constexpr std::uint8_t kOffsetNed = 2;              // TARGET_OBS_FRAME
constexpr std::uint8_t kVisionFiducial = 2;         // LANDING_TARGET_TYPE
constexpr std::uint8_t kByVision = 2;               // MAV_ESTIMATOR_TYPE
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

std::uint64_t Usec(const Sighting& sighting) {
  return static_cast<std::uint64_t>(std::llround(1e6 * std::max(0.0, sighting.t_s)));
}

std::array<float, 21> UpperTriangle(const Matrix6& m) {
  std::array<float, 21> triangle{};
  std::size_t at = 0;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) triangle[at++] = static_cast<float>(m(row, column));
  return triangle;
}

std::array<float, 4> ToArray(const Eigen::Quaterniond& q) {
  return {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
          static_cast<float>(q.z())};
}

// Of the place in axes turned from T by R, and of roll, pitch and yaw. Roll and pitch are about axes that turn with the
// heading; to the first order in them, near level.
Matrix6 InAngles(const Sighting& sighting, const Eigen::Matrix3d& R) {
  Matrix6 J = Matrix6::Zero();
  J.topLeftCorner<3, 3>() = R;
  J.bottomRightCorner<3, 3>() = HeadingRotation(YawOf(sighting.R_TB)).conjugate().toRotationMatrix();
  return J * sighting.covariance * J.transpose();
}

Eigen::Vector3d TargetInB(const Sighting& sighting) { return sighting.R_TB.conjugate() * -sighting.p_TB; }

}  // namespace

LandingTarget ToLandingTarget(const Sighting& sighting, const Pose& X_NB, const Dialect& dialect) {
  return ToLandingTarget(X_NB.R * TargetInB(sighting) + X_NB.p, X_NB, dialect, Usec(sighting));
}

TargetRelative ToTargetRelative(const Sighting& sighting, const Eigen::Quaterniond& R_NB) {
  const Eigen::Quaterniond R_NT = R_NB * sighting.R_TB.conjugate();
  const Eigen::Vector3f p = (R_NT * -sighting.p_TB).cast<float>();
  const Eigen::Matrix3d R = R_NT.toRotationMatrix();
  const Eigen::Matrix3d place = R * sighting.covariance.topLeftCorner<3, 3>() * R.transpose();
  TargetRelative message{.timestamp = Usec(sighting), .x = p.x(), .y = p.y(), .z = p.z()};
  for (int i = 0; i < 3; ++i)
    message.pos_std[static_cast<std::size_t>(i)] = static_cast<float>(std::sqrt(place(i, i)));
  message.yaw_std = static_cast<float>(std::sqrt(sighting.covariance(5, 5)));
  message.q_target = ToArray(R_NT.normalized());
  message.q_sensor = ToArray(Eigen::Quaterniond::Identity());
  message.frame = kOffsetNed;
  message.type = kVisionFiducial;
  return message;
}

Odometry ToOdometry(const Sighting& sighting) {
  const Eigen::Vector3f p = sighting.p_TB.cast<float>();
  Odometry message{.time_usec = Usec(sighting),
                   .x = p.x(),
                   .y = p.y(),
                   .z = p.z(),
                   .q = ToArray(sighting.R_TB.normalized()),
                   .vx = kUnknown,
                   .vy = kUnknown,
                   .vz = kUnknown,
                   .rollspeed = kUnknown,
                   .pitchspeed = kUnknown,
                   .yawspeed = kUnknown,
                   .pose_covariance = UpperTriangle(InAngles(sighting, Eigen::Matrix3d::Identity())),
                   .frame_id = kLocalFrd,
                   .child_frame_id = kBody,
                   .estimator_type = kByVision};
  message.velocity_covariance[0] = kUnknown;
  return message;
}

VisionPositionEstimate ToVisionPosition(const Sighting& sighting, double yaw_NB) {
  const Eigen::Matrix3d R = HeadingRotation(WrapAngle(yaw_NB - YawOf(sighting.R_TB))).toRotationMatrix();
  const Eigen::Vector3f p = (R * sighting.p_TB).cast<float>();
  const TaitBryan angles = TaitBryanFromRotation(sighting.R_TB.toRotationMatrix());
  return {.usec = Usec(sighting),
          .x = p.x(),
          .y = p.y(),
          .z = p.z(),
          .roll = static_cast<float>(angles.roll),
          .pitch = static_cast<float>(angles.pitch),
          .yaw = static_cast<float>(yaw_NB),
          .covariance = UpperTriangle(InAngles(sighting, R))};
}

}  // namespace kestrel::control::wire::mavlink
