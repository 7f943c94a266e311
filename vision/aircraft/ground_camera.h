// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "vision/camera.h"

// A camera that stands on the ground and sees the aircraft: eye-to-hand, thesis 5.2.1. Frames: G of its mast
// (x where the camera looks at rest, y to the right of it, z down when the mast is upright), C of the camera.
namespace kestrel::vision {

// How far the head on the mast has turned the camera: pan about z of G, to the right, and on that tilt,
// upwards; rad. A camera without a head is at zero.
struct PanTilt {
  double pan = 0, tilt = 0;
};

// Where the mast stands, as survey or calibration knows it, beside the pad.
struct GroundPlace {
  Eigen::Vector3d position_m{-15, 0,
                             2};  // of the camera: along x and y of T, and the height above the pad's face
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;  // of G in T: clockwise from x of T, up, right side down
  double position_sigma_m = 0.03;                   // of each, standard deviation
  double angle_sigma_deg = 0.1;
};

inline void Fields(FieldVisitor& v, GroundPlace& p) {
  v({"position_m",
     "place of the camera: along the up of the pad's picture, to the right of it, and above the pad's face"},
    p.position_m, -200.0, 200.0);
  v({"yaw_deg", "direction in which the camera looks, clockwise from the up of the pad's picture"}, p.yaw_deg,
    -360.0, 360.0);
  v({"pitch_deg", "how far it looks up"}, p.pitch_deg, -89.0, 89.0);
  v({"roll_deg", "how far its right side is lowered"}, p.roll_deg, -180.0, 180.0);
  v({"position_sigma_m", "standard deviation of each coordinate of the place, as it is known"},
    p.position_sigma_m, 0.0, 10.0);
  v({"angle_sigma_deg", "standard deviation of each angle, as it is known"}, p.angle_sigma_deg, 0.0, 20.0);
}

Pose MastPose(const GroundPlace& place);               // X_TG
Eigen::Quaterniond HeadRotation(const PanTilt& at);    // R_GC
Pose CameraPose(const Pose& X_TG, const PanTilt& at);  // X_TC
// At which the camera looks at a point; straight above or below, where pan makes no difference, it stays.
PanTilt LookAt(const Pose& X_TG, const Eigen::Vector3d& p_T, const PanTilt& now);

// A frame of it, and how the head stood at the exposure by its own encoders.
struct GroundFrame {
  Frame frame;
  PanTilt at;
};

// The camera as flight code has it: beside the one that paces the flight, never waited for.
class GroundCamera {
 public:
  virtual ~GroundCamera() = default;
  // The earliest frame that has come and was not taken yet; none: there is none.
  virtual std::optional<GroundFrame> Take() = 0;
  // Where the head is to turn from now on, within its travel; nothing of a camera without a head.
  virtual void Turn(const PanTilt& to) = 0;
};

}  // namespace kestrel::vision
