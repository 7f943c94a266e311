// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace kestrel {

// Yaw, pitch, roll (z-y-x), rad; thesis 4.3 to 4.5. Of R_NB: yaw clockwise from north, pitch nose up, roll
// right wing down.
struct TaitBryan {
  double yaw = 0;    // (-pi, pi]
  double pitch = 0;  // [-pi/2, pi/2]
  double roll = 0;   // (-pi, pi]
};

// The rotation R_AB of thesis 4.4. The thesis writes its transpose, R_BA: the matrix that turns coordinates
// of A into coordinates of B.
Eigen::Matrix3d RotationFromTaitBryan(const TaitBryan& angles);

// Thesis 4.5. Deviations: yaw and roll by arctangent, so that they hold over the whole circle where the
// printed arcsines hold to 90 degrees; the singularity is at pitch = +-90 degrees (the thesis says 0 and
// 180), and there the roll is set to zero, so that the angles still give the rotation back.
TaitBryan TaitBryanFromRotation(const Eigen::Matrix3d& R_AB);

// The yaw alone, and the rotation R_NH by it: the heading frame.
double YawOf(const Eigen::Quaterniond& R_AB);
Eigen::Quaterniond HeadingRotation(double yaw);

// The angle brought to (-pi, pi].
double WrapAngle(double angle_rad);

constexpr double Radians(double deg) { return deg * 0.017453292519943295; }
constexpr double Degrees(double rad) { return rad * 57.29577951308232; }

}  // namespace kestrel
