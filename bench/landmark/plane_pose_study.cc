// SPDX-License-Identifier: Apache-2.0
#include "bench/landmark/plane_pose_study.h"

#include <Eigen/Dense>
#include <cmath>

#include "base/random.h"
#include "geometry/pose.h"
#include "vision/landmark/estimation/plane_pnp.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Found = std::optional<Pose>;

std::vector<Vector2d> PointsOf(const PlanePoseStudy& study) {
  std::vector<Vector2d> points;
  for (int row = 0; row < study.rows; ++row)
    for (int col = 0; col < study.cols; ++col)
      points.emplace_back(study.size_m.x() * (row / (study.rows - 1.0) - 0.5),
                          study.size_m.y() * (col / (study.cols - 1.0) - 0.5));
  return points;
}

Found PoseOf(const std::optional<vision::PlanePose>& pose) {
  if (!pose) return std::nullopt;
  return pose->X_CT;
}

// In the order of kPlanePoseMethods.
std::array<Found, kPlanePoseMethods.size()> Estimates(const std::vector<vision::PointPair>& pairs,
                                                      const PlanePoseStudy& study) {
  const auto& camera = study.camera;
  std::array<Found, kPlanePoseMethods.size()> found;
  if (const auto H_w = vision::FitHomography(pairs)) found[0] = vision::PoseFromHomography(*H_w, camera);
  const auto both = vision::IppePoses(pairs, camera, study.sigma_px);
  if (!both.empty()) found[1] = both.front().X_CT;
  found[2] = PoseOf(vision::SqpnpPose(pairs, camera, study.sigma_px));
  if (found[0]) found[3] = PoseOf(vision::RefinePlanePose(pairs, camera, *found[0], study.sigma_px));
  found[4] = PoseOf(vision::MostLikelyPlanePose(pairs, camera, study.sigma_px));
  return found;
}

}  // namespace

double RadicalInverse(std::uint64_t i, unsigned base) {
  double value = 0, digit = 1;
  for (; i > 0; i /= base) value += static_cast<double>(i % base) * (digit /= base);
  return value;
}

std::vector<PlanePoseTrial> RunPlanePoseStudy(const PlanePoseStudy& study, std::uint64_t seed) {
  RandomStream random(seed, "plane pose");
  const std::vector<Vector2d> points = PointsOf(study);
  std::vector<PlanePoseTrial> trials;
  for (int i = 1; i <= study.poses; ++i) {
    const auto index = static_cast<std::uint64_t>(i);
    PlanePoseTrial trial;
    trial.distance_m = study.from_m * std::pow(study.to_m / study.from_m, RadicalInverse(index, 2));
    trial.tilt_rad = study.max_tilt_rad * RadicalInverse(index, 3);
    const double azimuth = 2 * M_PI * RadicalInverse(index, 5);
    const Pose X_CT{ExpRotation(trial.tilt_rad * Vector3d(std::cos(azimuth), std::sin(azimuth), 0)),
                    {0, 0, trial.distance_m}};
    const Eigen::Matrix3d H = vision::HomographyFromPose(X_CT, study.camera);
    const double m2 = study.size_m.prod();
    trial.size_px = std::sqrt(m2 * std::abs(H.determinant()) / std::pow(H(2, 2), 3));  // at its centre
    const auto information = vision::PoseInformation(points, study.camera, X_CT);
    if (!information) continue;
    const Eigen::Matrix<double, 6, 6> least = study.sigma_px * study.sigma_px * information->inverse();
    trial.bound = {least.topLeftCorner<3, 3>().trace(), least.bottomRightCorner<3, 3>().trace()};
    std::vector<vision::PointPair> pairs;
    for (const Vector2d& point : points) {
      const double du = random.Normal(), dv = random.Normal();
      pairs.push_back({point, vision::Transfer(H, point) + study.sigma_px * Vector2d(du, dv)});
    }
    const auto estimates = Estimates(pairs, study);
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      if (!estimates[k]) continue;
      trial.errors[k] = PoseSquares{(estimates[k]->p - X_CT.p).squaredNorm(),
                                    LogRotation(estimates[k]->R * X_CT.R.conjugate()).squaredNorm()};
    }
    trials.push_back(trial);
  }
  return trials;
}

}  // namespace kestrel::bench
