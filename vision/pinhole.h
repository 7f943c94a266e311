// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "config/fields.h"

namespace kestrel {

// Pinhole camera without distortion, thesis 3.16 and 5.1. Pixels: the centre of the first pixel is (0, 0), u
// to the right, v down.
struct Pinhole {
  int width_px = 0, height_px = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px

  // The pixel of a point given in C, m. Valid domain: z > 0; none outside it. The pixel may lie off the
  // image.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_CQ) const {
    if (!(p_CQ.z() > 0)) return std::nullopt;
    return Eigen::Vector2d(fx * p_CQ.x() / p_CQ.z() + cx, fy * p_CQ.y() / p_CQ.z() + cy);
  }
  // Unit vector in C through a pixel.
  Eigen::Vector3d Ray(const Eigen::Vector2d& uv) const {
    return Eigen::Vector3d((uv.x() - cx) / fx, (uv.y() - cy) / fy, 1).normalized();
  }
  // The calibration matrix K of thesis 3.16.
  Eigen::Matrix3d K() const {
    Eigen::Matrix3d k;
    k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
    return k;
  }
};

template <class Visitor>
void Fields(Visitor& v, Pinhole& c) {
  v(Required("width_px"), c.width_px, 16, 8192);
  v(Required("height_px"), c.height_px, 16, 8192);
  v(Required("fx_px"), c.fx, 1.0, 1e5);
  v(Required("fy_px"), c.fy, 1.0, 1e5);
  v(Required("cx_px"), c.cx, -1e5, 1e5);
  v(Required("cy_px"), c.cy, -1e5, 1e5);
}

}  // namespace kestrel
