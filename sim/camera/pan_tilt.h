// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>

#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::sim {

// A platform that turns the camera about two axes: pan about the aircraft's z, and on that, tilt. At zero the
// camera looks ahead; panned it looks to the right, tilted upwards. The numbers are assumed: none are known
// of the platforms of the thesis.
struct PanTiltParameters {
  double pan_min_deg = -170, pan_max_deg = 170;
  double tilt_min_deg = -90, tilt_max_deg = 30;
  double rate_deg_s = 90;  // of either
};

inline void Fields(FieldVisitor& v, PanTiltParameters& p) {
  v(Renamed("pan_min_deg", "pan_least_deg", "end of the travel of pan to the left"), p.pan_min_deg, -180.0,
    0.0);
  v(Renamed("pan_max_deg", "pan_most_deg", "end of the travel of pan to the right"), p.pan_max_deg, 0.0,
    180.0);
  v(Renamed("tilt_min_deg", "tilt_least_deg", "end of the travel of tilt downwards"), p.tilt_min_deg, -90.0,
    0.0);
  v(Renamed("tilt_max_deg", "tilt_most_deg", "end of the travel of tilt upwards"), p.tilt_max_deg, 0.0, 90.0);
  v({"rate_deg_s", "maximum rate of pan and of tilt"}, p.rate_deg_s, 1.0, 1000.0);
}

struct PanTiltAngles {
  double pan = 0, tilt = 0;  // rad
};

// Where the camera is to look: the same way from the aircraft, the same way in N whatever the aircraft does,
// or at a point. yaw and pitch are those of its axis, rad.
struct LookFromAircraft {
  double yaw = 0, pitch = 0;
};
struct LookInN {
  double yaw = 0, pitch = 0;
};
struct LookAt {
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();
};
using Gaze = std::variant<LookFromAircraft, LookInN, LookAt>;

// P, the platform's frame: x along the camera's axis, y to its right, z down.
Eigen::Quaterniond PlatformRotation(const PanTiltAngles& angles);  // R_BP
// The camera on it, X_BC; position_m: of the camera, where both axes meet, in B.
Pose PlatformPose(const PanTiltAngles& angles, const Eigen::Vector3d& position_m);

// The angles at which a camera on a platform is as this mount has it; none where there are none within the
// limits, as of a mount that is rolled.
std::optional<PanTiltAngles> AnglesOf(const vision::CameraMount& mount, const PanTiltParameters& parameters);

// The angles at which the camera looks there, within the limits. Where pan makes no difference, straight
// above or below, it stays at now.
PanTiltAngles AnglesFor(const Gaze& look, const Pose& X_NB, const Eigen::Vector3d& position_m,
                        const PanTiltAngles& now, const PanTiltParameters& parameters);
// Towards them, in dt_s, at the platform's rate.
PanTiltAngles Turned(const PanTiltAngles& now, const PanTiltAngles& wanted, double dt_s,
                     const PanTiltParameters& parameters);

// A platform in flight.
class PanTilt {
 public:
  // Holding the angles, as far as they are within the limits.
  PanTilt(const PanTiltParameters& parameters, const Eigen::Vector3d& position_m,
          const PanTiltAngles& angles);

  void Turn(const Gaze& look) { look_ = look; }
  // X_NB: where the autopilot believes the aircraft to be.
  void Step(double dt_s, const Pose& X_NB);

  const Gaze& look() const { return look_; }
  const PanTiltAngles& angles() const { return angles_; }
  Pose X_BC() const { return PlatformPose(angles_, position_m_); }
  const Eigen::Vector3d& position_m() const { return position_m_; }

 private:
  PanTiltParameters parameters_;
  Eigen::Vector3d position_m_;
  PanTiltAngles angles_;
  Gaze look_;
};

}  // namespace kestrel::sim
