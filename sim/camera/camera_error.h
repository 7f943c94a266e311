// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "base/yaml/fields.h"
#include "geometry/pose.h"
#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// How far a camera truly is from what flight code believes of it: from its calibration, its mount and its clock.
// Each is normal and drawn once a run, but for the jitter, which is drawn for each frame.
struct CameraErrorParameters {
  double focal = 0;       // standard deviation of the share by which the focal length is off
  double centre_px = 0;   // of each coordinate of the principal point
  double position_m = 0;  // root mean square of the distance from the mount
  double angle_deg = 0;   // root mean square of the angle from it
  double clock_offset_s = 0, clock_drift_ppm = 0, clock_jitter_s = 0;  // standard deviations, of stamps
};

inline void Fields(FieldVisitor& v, CameraErrorParameters& p) {
  v({"focal", "standard deviation of the share by which the true focal length is off the calibration"},
    p.focal, 0.0, 0.1);
  v({"centre_px", "standard deviation of each coordinate of the true principal point"}, p.centre_px, 0.0,
    100.0);
  v({"position_m", "root mean square of the distance of the true camera from its mount"}, p.position_m, 0.0,
    1.0);
  v({"angle_deg", "root mean square of the angle of the true camera from its mount"}, p.angle_deg, 0.0, 20.0);
  v({"clock_offset_s", "standard deviation of how far the stamps of frames are ahead, all flight long"},
    p.clock_offset_s, 0.0, 1.0);
  v({"clock_drift_ppm", "standard deviation of how much faster than the autopilot's the camera's clock goes"},
    p.clock_drift_ppm, 0.0, 1000.0);
  v({"clock_jitter_s", "standard deviation of the stamp of each frame"}, p.clock_jitter_s, 0.0, 0.1);
}

// The error of one run, by its seed; without parameters there is none, bit for bit.
class CameraError {
 public:
  CameraError(const CameraErrorParameters& parameters, std::uint64_t seed);

  vision::CameraModel Of(vision::CameraModel camera) const;  // the true one
  Pose Of(const Pose& X_BC) const;                           // the true one
  // What the frame of that number, exposed at t_s, is stamped with.
  double Stamp(double t_s, std::int64_t sequence) const;

 private:
  CameraErrorParameters parameters_;
  std::uint64_t seed_;
  double focal_ = 1;
  Eigen::Vector2d centre_px_ = Eigen::Vector2d::Zero();
  Pose X_MC_;  // M: the mount as flight code believes it
  double clock_offset_s_ = 0, clock_rate_ = 0;
};

}  // namespace kestrel::sim
