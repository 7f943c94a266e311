// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/yaml/fields.h"
#include "geometry/pose.h"

namespace kestrel::vision {

// A band of frequencies in which a camera shakes on its mount, about and along each of its axes alike.
struct VibrationBand {
  double from_hz = 80, until_hz = 120;
  double rms_deg = 0;
  double rms_mm = 0;
};

// The camera's place on the aircraft: looking down with the top of the image forward, then turned by the
// angles. Parts of the aircraft that are in view are seen.
struct CameraMount {
  Eigen::Vector3d position_m{0, 0, 0.05};  // in B
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
  std::vector<VibrationBand> vibration = {};
};
Pose MountPose(const CameraMount& mount);  // X_BC, of a mount that is still

inline void Fields(FieldVisitor& v, VibrationBand& b) {
  v({"from_hz", "lower end of the band of frequencies, such as rotors make"}, b.from_hz, 0.1, 500.0);
  v({"until_hz", "upper end of the band of frequencies"}, b.until_hz, 0.1, 500.0);
  v({"rms_deg", "rms rotation about each axis of the camera"}, b.rms_deg, 0.0, 5.0);
  v({"rms_mm", "rms displacement along each axis of the camera"}, b.rms_mm, 0.0, 50.0);
}

inline void Fields(FieldVisitor& v, CameraMount& m) {
  v({"position_m", "position of the camera on the aircraft: forward, right, down"}, m.position_m, -1.0, 1.0);
  v({"yaw_deg",
     "rotation about the aircraft's z (down), from looking down with the top of the image forward"},
    m.yaw_deg, -180.0, 180.0);
  v({"pitch_deg", "rotation about the aircraft's y (right); 90: looks ahead"}, m.pitch_deg, -90.0, 90.0);
  v({"roll_deg", "rotation about the aircraft's x (forward); 180: looks up"}, m.roll_deg, -180.0, 180.0);
  v({"vibration", "bands of frequencies in which a simulated mount shakes; none: it is still"}, m.vibration);
}

}  // namespace kestrel::vision
