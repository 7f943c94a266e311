// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/pan_tilt.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr double kAlongAxis = 1e-9;  // sine of the angle to the pan axis below which pan makes no difference

PanTiltAngles Within(const PanTiltAngles& wanted, const PanTiltParameters& p) {
  return {std::clamp(WrapAngle(wanted.pan), Radians(p.pan_min_deg), Radians(p.pan_max_deg)),
          std::clamp(WrapAngle(wanted.tilt), Radians(p.tilt_min_deg), Radians(p.tilt_max_deg))};
}

// That turn the axis to this direction.
PanTiltAngles Toward(const Eigen::Vector3d& ray_B, const PanTiltAngles& now) {
  const double level = ray_B.head<2>().norm();
  if (!(ray_B.norm() > 0)) return now;
  return {level > kAlongAxis * ray_B.norm() ? std::atan2(ray_B.y(), ray_B.x()) : now.pan,
          std::atan2(-ray_B.z(), level)};
}

double Approach(double now, double wanted, double most) {
  return now + std::clamp(wanted - now, -most, most);
}

}  // namespace

Eigen::Quaterniond PlatformRotation(const PanTiltAngles& angles) {
  return Eigen::Quaterniond(RotationFromTaitBryan({.yaw = angles.pan, .pitch = angles.tilt, .roll = 0}));
}

Pose PlatformPose(const PanTiltAngles& angles, const Eigen::Vector3d& position_m) {
  Eigen::Matrix3d R_PC;
  R_PC << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return {PlatformRotation(angles) * Eigen::Quaterniond(R_PC), position_m};
}

std::optional<PanTiltAngles> AnglesOf(const vision::CameraMount& mount, const PanTiltParameters& parameters) {
  const PanTiltAngles angles = Within({Radians(mount.yaw_deg), Radians(mount.pitch_deg - 90)}, parameters);
  const Pose mounted = vision::MountPose(mount);
  constexpr double kSame = 1e-6;  // rad
  if (PlatformPose(angles, mounted.p).R.angularDistance(mounted.R) > kSame) return std::nullopt;
  return angles;
}

PanTiltAngles AnglesFor(const Gaze& look, const Pose& X_NB, const Eigen::Vector3d& position_m,
                        const PanTiltAngles& now, const PanTiltParameters& parameters) {
  if (const auto* fixed = std::get_if<LookFromAircraft>(&look))
    return Within({fixed->yaw, fixed->pitch}, parameters);
  Eigen::Vector3d ray_B;
  if (const auto* level = std::get_if<LookInN>(&look))
    ray_B = X_NB.R.conjugate() * (PlatformRotation({level->yaw, level->pitch}) * Eigen::Vector3d::UnitX());
  else
    ray_B = X_NB.Inverse() * std::get<LookAt>(look).p_N - position_m;
  return Within(Toward(ray_B, now), parameters);
}

PanTiltAngles Turned(const PanTiltAngles& now, const PanTiltAngles& wanted, double dt_s,
                     const PanTiltParameters& parameters) {
  const double most = Radians(parameters.rate_deg_s) * dt_s;
  return {Approach(now.pan, wanted.pan, most), Approach(now.tilt, wanted.tilt, most)};
}

PanTilt::PanTilt(const PanTiltParameters& parameters, const Eigen::Vector3d& position_m,
                 const PanTiltAngles& angles)
    : parameters_(parameters),
      position_m_(position_m),
      angles_(Within(angles, parameters)),
      look_(LookFromAircraft{angles_.pan, angles_.tilt}) {}

void PanTilt::Step(double dt_s, const Pose& X_NB) {
  angles_ = Turned(angles_, AnglesFor(look_, X_NB, position_m_, angles_, parameters_), dt_s, parameters_);
}

}  // namespace kestrel::sim
