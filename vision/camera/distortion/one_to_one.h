// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <optional>

namespace kestrel::vision {

// The point of the domain that is distorted to this one, to 1e-12; none: there is none. By Newton's method
// from the centre, with steps cut so that they stay in the domain and come nearer. distortion has
// Distort(m, &d_m), Holds(radius), and MaxDistorted(), further out than which no point of the domain goes.
template <class Distortion>
std::optional<Eigen::Vector2d> UndistortOneToOne(const Distortion& distortion,
                                                 const Eigen::Vector2d& distorted) {
  if (!distorted.allFinite()) return std::nullopt;
  const double scale = 1 + distorted.norm();
  bool reachable = false;  // known to be; asked only when a step leaves the domain
  Eigen::Vector2d m = Eigen::Vector2d::Zero(), left = distorted;
  for (int i = 0; i < 100 && left.norm() > 1e-15 * scale; ++i) {
    Eigen::Matrix2d d_m;
    distortion.Distort(m, &d_m);
    const Eigen::Vector2d step = d_m.inverse() * left;
    double share = 1;
    for (; share > 1e-18; share /= 2) {
      const Eigen::Vector2d next = m + share * step;
      if (!distortion.Holds(next.norm())) {
        if (!reachable && distorted.norm() > distortion.MaxDistorted()) return std::nullopt;
        reachable = true;
        continue;
      }
      const Eigen::Vector2d next_left = distorted - distortion.Distort(next);
      if (!(next_left.norm() < left.norm())) continue;
      m = next, left = next_left;
      break;
    }
    if (share <= 1e-18) break;
  }
  if (!(left.norm() <= 1e-12 * scale)) return std::nullopt;
  return m;
}

}  // namespace kestrel::vision
