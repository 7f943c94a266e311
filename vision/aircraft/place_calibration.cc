// SPDX-License-Identifier: Apache-2.0
#include "vision/aircraft/place_calibration.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace kestrel::vision {
namespace {

constexpr int kFewest = 30;
constexpr double kMaxTurnSigma = 0.02;  // rad; above it the places are no more than a line
constexpr double kMaxPlaceSigma_m = 0.5;
constexpr double kHuber = 2.5;
constexpr double kLeastFactor = 0.01;  // of the variances
constexpr int kMostSteps = 30;

// Two axes across a direction.
Eigen::Matrix<double, 2, 3> Across(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d a = direction.unitOrthogonal();
  Eigen::Matrix<double, 2, 3> rows;
  rows << a.transpose(), direction.cross(a).transpose();
  return rows;
}

// The residual of a sighting in sigmas, across and along the line of sight, and its derivative by a shift and a
// turn of G in T.
struct Residual {
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 6> J;
};
Residual ResidualOf(const PlaceSighting& s, const Pose& X_TG) {
  const Eigen::Matrix3d R_GT = X_TG.R.conjugate().toRotationMatrix();
  const Eigen::Vector3d arm_T = s.p_TB - X_TG.p, p_G = R_GT * arm_T;
  const double range = p_G.norm();
  const Eigen::Vector3d seen = s.p_GB.normalized();
  const Eigen::Matrix<double, 2, 3> across = Across(seen);
  const double across_m = std::hypot(s.sigma_m, s.bearing_sigma * range);
  const double along_m = std::hypot(s.sigma_m, s.range_sigma_m);
  Residual out;
  out.r << -across * p_G / across_m, (s.p_GB.norm() - range) / along_m;
  Eigen::Matrix3d by_p_G;
  by_p_G << -across / across_m, -p_G.transpose() / range / along_m;
  // p_G = R_TG^T (p - t): a shift of t, and a turn exp(w) R_TG of G in T.
  out.J << by_p_G * -R_GT, by_p_G * (R_GT * Skew(arm_T));
  return out;
}

}  // namespace

const char* NameOf(PlaceState state) {
  constexpr const char* kNames[] = {"found", "too few sightings", "not spread"};
  return kNames[static_cast<int>(state)];
}

PlaceCalibration CalibratePlace(const std::vector<PlaceSighting>& sightings, double period_s,
                                double memory_s) {
  PlaceCalibration out;
  const auto count = static_cast<Eigen::Index>(sightings.size());
  if (count < kFewest) return out;
  Eigen::Matrix3Xd in_T(3, count), in_G(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    in_T.col(i) = sightings[static_cast<std::size_t>(i)].p_TB;
    in_G.col(i) = sightings[static_cast<std::size_t>(i)].p_GB;
  }
  const Eigen::Matrix4d start = Eigen::umeyama(in_G, in_T, false);
  out.X_TG.R = Eigen::Quaterniond(Eigen::Matrix3d(start.topLeftCorner<3, 3>())).normalized();
  out.X_TG.p = start.topRightCorner<3, 1>();

  Eigen::Matrix<double, 6, 6> H;
  for (int k = 0; k < kMostSteps; ++k) {
    H.setZero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    double squared = 0;
    out.sightings = 0;
    for (const PlaceSighting& s : sightings) {
      const Residual e = ResidualOf(s, out.X_TG);
      const double size = e.r.norm(), weight = size > kHuber ? kHuber / size : 1;
      H += weight * e.J.transpose() * e.J;
      g += weight * e.J.transpose() * e.r;
      if (size > 2 * kHuber) continue;
      squared += e.r.squaredNorm() / 3;
      ++out.sightings;
    }
    out.residual = std::sqrt(squared / std::max(1, out.sightings));
    H.diagonal().array() += 1e-9;
    const Eigen::Matrix<double, 6, 1> step = -H.ldlt().solve(g);
    if (!step.allFinite()) break;
    out.X_TG.p += step.head<3>();
    out.X_TG.R = (ExpRotation(step.tail<3>()) * out.X_TG.R).normalized();
    if (step.norm() < 1e-9) break;
  }
  if (out.sightings < kFewest) return out;
  const double alike = std::max(1.0, memory_s / std::max(period_s, 1e-3));
  // The errors are as large as what is left says, not as they were said to be.
  out.covariance = H.inverse() * alike * std::max(kLeastFactor, out.residual * out.residual);
  const Eigen::Matrix<double, 6, 1> sigma = out.covariance.diagonal().cwiseSqrt();
  const bool spread =
      sigma.head<3>().maxCoeff() < kMaxPlaceSigma_m && sigma.tail<3>().maxCoeff() < kMaxTurnSigma;
  out.state = spread ? PlaceState::kFound : PlaceState::kNotSpread;
  return out;
}

}  // namespace kestrel::vision
