// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/estimation/plane_pnp.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

namespace kestrel::vision {
namespace {

// A pose with its error and covariance. None: a point lies behind the camera, or the points leave the pose open.
std::optional<PlanePose> Judged(const Pose& X_CT, std::span<const PointPair> pairs, const Pinhole& camera,
                                double sigma_px) {
  std::vector<Eigen::Vector2d> on_plane;
  double squares = 0;
  for (const PointPair& pair : pairs) {
    const auto uv = camera.Project(X_CT * Eigen::Vector3d(pair.from.x(), pair.from.y(), 0));
    if (!uv) return std::nullopt;
    squares += (pair.to - *uv).squaredNorm();
    on_plane.push_back(pair.from);
  }
  const auto information = PoseInformation(on_plane, camera, X_CT);
  if (!information || !std::isfinite(squares)) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(*information);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
  const double n = static_cast<double>(pairs.size());
  const double sigma = std::max(sigma_px, std::sqrt(squares / std::max(2 * n - 6, 1.0)));
  return PlanePose{X_CT, sigma * sigma * solver.solve(Eigen::Matrix<double, 6, 6>::Identity()),
                   std::sqrt(squares / n)};
}

// Of points all on one line: how far they are from it, as a share of how far they reach along it.
bool OnALine(std::span<const PointPair> pairs) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const PointPair& pair : pairs) centre += pair.from / static_cast<double>(pairs.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const PointPair& pair : pairs) spread += (pair.from - centre) * (pair.from - centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  return !(solver.eigenvalues()(0) > 1e-8 * solver.eigenvalues()(1));  // written so that NaN is
}

std::vector<PlanePose> Solutions(std::span<const PointPair> pairs, const Pinhole& camera, double sigma_px,
                                 cv::SolvePnPMethod method) {
  std::vector<PlanePose> poses;
  if (pairs.size() < 4 || OnALine(pairs)) return poses;
  std::vector<cv::Point3d> on_plane;
  std::vector<cv::Point2d> pixels;
  for (const PointPair& pair : pairs) {
    if (!pair.to.allFinite()) return poses;
    on_plane.emplace_back(pair.from.x(), pair.from.y(), 0);
    pixels.emplace_back(pair.to.x(), pair.to.y());
  }
  cv::Mat K;
  cv::eigen2cv(camera.K(), K);
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::solvePnPGeneric(on_plane, pixels, K, cv::noArray(), rotations, translations, false, method);
  } catch (const cv::Exception&) {  // its word for pixels that coincide
    return poses;
  }
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    Eigen::Vector3d r, t;
    cv::cv2eigen(rotations[i], r);
    cv::cv2eigen(translations[i], t);
    if (!r.allFinite() || !t.allFinite()) continue;
    if (const auto pose = Judged({ExpRotation(r), t}, pairs, camera, sigma_px)) poses.push_back(*pose);
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const PlanePose& a, const PlanePose& b) { return a.rms_px < b.rms_px; });
  return poses;
}

}  // namespace

std::vector<PlanePose> IppePoses(std::span<const PointPair> pairs, const Pinhole& camera, double sigma_px) {
  return Solutions(pairs, camera, sigma_px, cv::SOLVEPNP_IPPE);
}

std::optional<PlanePose> SqpnpPose(std::span<const PointPair> pairs, const Pinhole& camera, double sigma_px) {
  const std::vector<PlanePose> poses = Solutions(pairs, camera, sigma_px, cv::SOLVEPNP_SQPNP);
  if (poses.empty()) return std::nullopt;
  return poses.front();
}

std::optional<PlanePose> MostLikelyPlanePose(std::span<const PointPair> pairs, const Pinhole& camera,
                                             double sigma_px) {
  std::optional<PlanePose> best;
  for (const PlanePose& start : IppePoses(pairs, camera, sigma_px)) {
    const auto refined = RefinePlanePose(pairs, camera, start.X_CT, sigma_px);
    if (refined && (!best || refined->rms_px < best->rms_px)) best = refined;
  }
  return best;
}

}  // namespace kestrel::vision
