// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace kestrel::vision {

// What a mosaic is drawn on, the rendering transformations of thesis 4.3 (Capel 2001).
enum class Surface {
  kPlane,     // keeps straight lines; less than half of what is around
  kCylinder,  // about the y axis of W, unrolled: columns are azimuths, rows tangents of elevations
  kSphere     // columns are azimuths, rows elevations
};

// W is the frame of a mosaic, with the axes of a camera: x right, y down, z forward. A place of the mosaic is a
// direction in W, of any length. Pixels of a surface are counted from where its z axis meets it, f_px of them to
// a radian there.

// Where a direction meets the surface; none: it does not. With the origin of the sphere moved by pi/2 f_px these
// are the projectors of OpenCV's stitching.
std::optional<Eigen::Vector2d> OnSurface(Surface surface, double f_px, const Eigen::Vector3d& w);
// The other way; none: no direction meets the surface there.
std::optional<Eigen::Vector3d> FromSurface(Surface surface, double f_px, const Eigen::Vector2d& uv);

}  // namespace kestrel::vision
