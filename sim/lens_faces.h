// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "vision/camera_model.h"

namespace kestrel {

// OpenGL draws pinhole pictures with square pixels. Any other lens is put together of some: its faces, all
// with the lens's viewpoint, each turned its own way and only as large as the lens needs.
struct Face {
  Eigen::Quaterniond R_CV;  // V: the face's own camera, optical
  Pinhole camera;           // its middle is seldom in the middle of the picture
  std::size_t first = 0;    // where its first pixel lies when all faces lie in one array
};

// Where a pixel of the lens lies in the faces: between four of their pixels.
struct Texel {
  static constexpr std::uint32_t kOutside = ~std::uint32_t{0};
  std::uint32_t at =
      kOutside;  // the one to the lower left, in the array of all faces; rows go up, as in OpenGL
  std::uint16_t right = 0, up = 0;  // how far from it, in 65536ths of a pixel
  std::uint32_t face = 0;
};

struct LensFaces {
  int width_px = 0, height_px = 0;  // of the lens's image
  std::vector<Face> faces;
  std::size_t pixels = 0;      // of all faces
  std::vector<Texel> texels;   // one for each pixel of the lens, row by row
  std::vector<float> stretch;  // of each: the distance along its ray for a depth of 1 in its face
};

// The lens as its only face, if it is a pinhole with square pixels that shows all of its image.
std::optional<LensFaces> OnlyFace(const CameraModel& camera);

// Which way the faces look: the axis of each. A ray belongs to the face whose axis is nearest.
using FaceLayout = std::vector<Eigen::Quaterniond>;  // R_CV of each
// A cube turned by R_CK: K has a face to each side along each of its axes.
FaceLayout Cube(const Eigen::Quaterniond& R_CK = Eigen::Quaterniond::Identity());

// Faces so fine that their pixels are at most half of the lens's: measured on each face where the lens is
// densest, but for a thousandth of the pixels, since a lens may fold at its rim. No side is longer than
// max_side_px, even if a face has to be coarser for that. Faces overlap by enough for interpolation; those
// that the lens does not use are left out. None at all where a ray is 75 degrees or more from every axis.
std::optional<LensFaces> PlanFaces(const CameraModel& camera, const FaceLayout& layout, int max_side_px);
// One plane if it is drawn sooner than a cube.
LensFaces PlanFaces(const CameraModel& camera, int max_side_px);

}  // namespace kestrel
