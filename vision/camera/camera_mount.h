// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/yaml/fields.h"
#include "geometry/pose.h"

namespace kestrel::vision {

// A band of frequencies in which a camera shakes on its mount, about and along each of its axes alike.
struct VibrationBand {
  double from_hz = 80, until_hz = 120;  // such as rotors make
  double rms_deg = 0;                   // of the angle about each axis
  double rms_mm = 0;                    // of the way along each axis
};

// The camera's place on the aircraft: looking down with the top of the image forward, then turned by the
// angles (pitch 90: looking ahead; roll 180: looking up). Parts of the aircraft that are in view are seen.
// The vibration is a simulated mount's.
struct CameraMount {
  Eigen::Vector3d position_m{0, 0, 0.05};  // in B
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
  std::vector<VibrationBand> vibration = {};
};
Pose MountPose(const CameraMount& mount);  // X_BC, of a mount that is still

inline void Fields(FieldVisitor& v, VibrationBand& b) {
  v("from_hz", b.from_hz, 0.1, 500.0);
  v("until_hz", b.until_hz, 0.1, 500.0);
  v("rms_deg", b.rms_deg, 0.0, 5.0);
  v("rms_mm", b.rms_mm, 0.0, 50.0);
}

inline void Fields(FieldVisitor& v, CameraMount& m) {
  v("position_m", m.position_m, -1.0, 1.0);
  v("yaw_deg", m.yaw_deg, -180.0, 180.0);
  v("pitch_deg", m.pitch_deg, -90.0, 90.0);
  v("roll_deg", m.roll_deg, -180.0, 180.0);
  v("vibration", m.vibration);
}

}  // namespace kestrel::vision
