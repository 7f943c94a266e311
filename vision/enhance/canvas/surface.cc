// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/surface.h"

#include <cmath>
#include <numbers>

namespace kestrel::vision {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Vector2d> OnSurface(Surface surface, double f_px, const Vector3d& w) {
  const double across = std::hypot(w.x(), w.z());
  switch (surface) {
    case Surface::kPlane:
      if (!(w.z() > 0)) return std::nullopt;
      return Vector2d(f_px * w.x() / w.z(), f_px * w.y() / w.z());
    case Surface::kCylinder:
      if (!(across > 0)) return std::nullopt;
      return Vector2d(f_px * std::atan2(w.x(), w.z()), f_px * w.y() / across);
    case Surface::kSphere:
      if (!(w.squaredNorm() > 0)) return std::nullopt;
      return Vector2d(f_px * std::atan2(w.x(), w.z()), f_px * std::atan2(w.y(), across));
  }
  return std::nullopt;
}

std::optional<Vector3d> FromSurface(Surface surface, double f_px, const Vector2d& uv) {
  const Vector2d at = uv / f_px;
  switch (surface) {
    case Surface::kPlane:
      return Vector3d(at.x(), at.y(), 1);
    case Surface::kCylinder:
      if (std::abs(at.x()) > std::numbers::pi) return std::nullopt;
      return Vector3d(std::sin(at.x()), at.y(), std::cos(at.x()));
    case Surface::kSphere:
      if (std::abs(at.x()) > std::numbers::pi || std::abs(at.y()) > std::numbers::pi / 2) return std::nullopt;
      return Vector3d(std::sin(at.x()) * std::cos(at.y()), std::sin(at.y()),
                      std::cos(at.x()) * std::cos(at.y()));
  }
  return std::nullopt;
}

}  // namespace kestrel::vision
