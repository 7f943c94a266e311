// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/motion_estimate.h"

#include <Eigen/LU>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "vision/camera/views.h"
#include "vision/enhance/motion/ray_rotation.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Rays {
  std::vector<PixelPair> pairs;
  std::vector<Vector3d> a, b;
};

Rays RaysOf(const CameraModel& camera, std::span<const PixelPair> pairs) {
  Rays rays;
  for (const PixelPair& pair : pairs) {
    const auto a = Ray(camera, pair.a), b = Ray(camera, pair.b);
    if (!a || !b) continue;
    rays.pairs.push_back(pair);
    rays.a.push_back(*a);
    rays.b.push_back(*b);
  }
  return rays;
}

std::vector<int> Agreeing(const CameraModel& camera, const Rays& rays, const Matrix3d& M_AB,
                          double threshold_px, double* squares = nullptr) {
  std::vector<int> agreeing;
  if (squares) *squares = 0;
  for (std::size_t i = 0; i < rays.a.size(); ++i) {
    const auto a = Project(camera, M_AB * rays.b[i]);
    if (!a) continue;
    const double square = (*a - rays.pairs[i].a).squaredNorm();
    if (square > threshold_px * threshold_px) continue;
    agreeing.push_back(static_cast<int>(i));
    if (squares) *squares += square;
  }
  return agreeing;
}

std::optional<Matrix3d> EstimateRotation(const CameraModel& camera, const Rays& rays, double threshold_px) {
  std::vector<RayPair> pairs;
  for (std::size_t i = 0; i < rays.a.size(); ++i) pairs.push_back({rays.b[i], rays.a[i]});
  const auto rotation = FitRobustRotation(pairs, threshold_px / CentralResolution(camera), 2);
  if (!rotation) return std::nullopt;
  return rotation->R.toRotationMatrix();
}

// Points of the plane z = 1, in pixels of a camera without distortion.
std::optional<Matrix3d> EstimateHomography(const Rays& rays, double f_px, double threshold_px) {
  if (rays.a.size() < 4) return std::nullopt;
  std::vector<cv::Point2d> a, b;
  for (std::size_t i = 0; i < rays.a.size(); ++i) {
    a.emplace_back(f_px * rays.a[i].x() / rays.a[i].z(), f_px * rays.a[i].y() / rays.a[i].z());
    b.emplace_back(f_px * rays.b[i].x() / rays.b[i].z(), f_px * rays.b[i].y() / rays.b[i].z());
  }
  const cv::Mat found = cv::findHomography(b, a, cv::RANSAC, threshold_px);
  if (found.empty()) return std::nullopt;
  Matrix3d H;
  cv::cv2eigen(found, H);
  const Vector3d f(f_px, f_px, 1);
  return Matrix3d(f.cwiseInverse().asDiagonal() * H * f.asDiagonal());
}

// A camera sees a plane from one side, and neither from far nearer nor from far farther.
bool IsOfACamera(const Matrix3d& H) {
  const double det = H.determinant(), scale = std::sqrt(std::abs(det / (H(2, 2) * H(2, 2) * H(2, 2))));
  return H.allFinite() && H(2, 2) > 0 && det > 0 && scale > 0.1 && scale < 10;
}

}  // namespace

std::optional<MotionEstimate> EstimateMotion(MosaicModel model, const CameraModel& camera,
                                             std::span<const PixelPair> pairs, double threshold_px,
                                             int min_pairs) {
  Rays rays = RaysOf(camera, pairs);
  if (model == MosaicModel::kPlane) {  // beyond, a plane is not met
    Rays ahead;
    for (std::size_t i = 0; i < rays.a.size(); ++i) {
      if (!(rays.a[i].z() > 0.1 && rays.b[i].z() > 0.1)) continue;
      ahead.pairs.push_back(rays.pairs[i]);
      ahead.a.push_back(rays.a[i]);
      ahead.b.push_back(rays.b[i]);
    }
    rays = std::move(ahead);
  }
  if (static_cast<int>(rays.a.size()) < min_pairs) return std::nullopt;
  std::optional<Matrix3d> M;
  if (model == MosaicModel::kRotation) {
    M = EstimateRotation(camera, rays, threshold_px);
  } else {
    Eigen::Matrix<double, 2, 3> d_point;
    const double f_px = Project(camera, {0, 0, 1}, &d_point) ? d_point(0, 0) : WidthPx(camera);
    M = EstimateHomography(rays, f_px, threshold_px);
    if (M && !IsOfACamera(*M)) return std::nullopt;
  }
  if (!M) return std::nullopt;
  MotionEstimate estimate;
  estimate.M_AB = *M;
  double squares = 0;
  for (const int i : Agreeing(camera, rays, *M, threshold_px, &squares))
    estimate.pairs.push_back(rays.pairs[static_cast<std::size_t>(i)]);
  if (static_cast<int>(estimate.pairs.size()) < min_pairs) return std::nullopt;
  estimate.rms_px = std::sqrt(squares / static_cast<double>(estimate.pairs.size()));
  return estimate;
}

}  // namespace kestrel::vision
