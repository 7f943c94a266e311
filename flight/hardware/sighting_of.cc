// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/sighting_of.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"
#include "vision/camera/camera_model.h"

namespace kestrel::flight {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Fisher's information of a grid of points over the pad that the camera sees, of pixels with the deviation 1, on place
// and attitude in T; for one point. None: it sees none of them.
std::optional<Matrix6> InformationPerPoint(const Pose& X_TB, const mission::MissionParts& parts) {
  constexpr int kGrid = 21;  // so dense that enough of it is in view of one who is about to touch down
  const Pose X_CT = (X_TB * parts.X_BC).Inverse();
  const Eigen::Matrix3d R_CT = X_CT.R.toRotationMatrix();
  Matrix6 information = Matrix6::Zero();
  int seen = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const Eigen::Vector3d p_TQ((i / (kGrid - 1.0) - 0.5) * parts.pad.length_m,
                                 (j / (kGrid - 1.0) - 0.5) * parts.pad.width_m, 0);
      Eigen::Matrix<double, 2, 3> by_point;
      const auto pixel = vision::Project(parts.camera, X_CT * p_TQ, &by_point);
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > vision::WidthPx(parts.camera) - 1 ||
          pixel->y() > vision::HeightPx(parts.camera) - 1)
        continue;
      Eigen::Matrix<double, 3, 6> by_pose;
      by_pose << -R_CT, R_CT * Skew(p_TQ - X_TB.p);
      const Eigen::Matrix<double, 2, 6> J = by_point * by_pose;
      information += J.transpose() * J;
      ++seen;
    }
  if (seen == 0) return std::nullopt;
  return Matrix6(information / seen);
}

}  // namespace

control::Sighting SightingOf(const mission::TargetFix& fix, double t_s, const control::VehicleState& state,
                             const mission::MissionParts& parts) {
  TaitBryan angles = TaitBryanFromRotation(state.R_NB.toRotationMatrix());
  angles.yaw = fix.yaw_TB;
  control::Sighting sighting{
      .t_s = t_s, .p_TB = fix.p_TB, .R_TB = Eigen::Quaterniond(RotationFromTaitBryan(angles))};
  sighting.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto information = InformationPerPoint({sighting.R_TB, sighting.p_TB}, parts);
  if (!information || fix.inliers < 4) return sighting;
  const Eigen::LDLT<Matrix6> solver(*information);
  if (solver.info() != Eigen::Success || !solver.isPositive() || solver.rcond() < 1e-12) return sighting;
  const double sigma_px = std::max(kMinResidual_px, fix.residual_px);
  sighting.covariance = sigma_px * sigma_px / fix.inliers * solver.solve(Matrix6::Identity());
  return sighting;
}

}  // namespace kestrel::flight
