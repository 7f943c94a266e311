// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "vision/camera/camera_model.h"

namespace kestrel::sim {

// OpenGL draws pinhole pictures with square pixels. Any other lens is put together of some: its faces, all
// with the lens's viewpoint, each turned its own way and only as large as the lens needs.
struct Face {
  Eigen::Quaterniond R_CV;  // V: the face's own camera, optical
  vision::Pinhole camera;   // its middle is seldom in the middle of the picture
  std::size_t first = 0;    // where its first pixel lies when all faces lie in one array
};

// The part of a face that a pixel of the lens shows: a parallelogram. Places are in 65536ths of a pixel of
// the face, from the middle of its lower left pixel; rows go up, as in OpenGL.
struct Patch {
  static constexpr std::uint16_t kOutside = 0xFFFF;
  std::uint16_t face = kOutside;                    // of a pixel outside the lens: none
  std::uint8_t across_u = 1, across_v = 1;          // face pixels along its sides, rounded up
  std::int32_t x = 0, y = 0;                        // its middle
  std::int32_t u_x = 0, u_y = 0, v_x = 0, v_y = 0;  // its sides: one pixel of the lens further
};

struct LensFaces {
  int width_px = 0, height_px = 0;  // of the lens's image
  std::vector<Face> faces;
  std::size_t pixels = 0;      // of all faces
  std::vector<Patch> patches;  // one for each pixel of the lens, row by row
  std::vector<float> stretch;  // of each: the distance along its ray for a depth of 1 in its face
};

// The lens as its only face, if it is a pinhole with square pixels that shows all of its image.
std::optional<LensFaces> OnlyFace(const vision::CameraModel& camera);

// Which way the faces look: the axis of each. A ray belongs to the face whose axis is nearest.
using FaceLayout = std::vector<Eigen::Quaterniond>;  // R_CV of each
// A cube turned by R_CK: K has a face to each side along each of its axes.
FaceLayout Cube(const Eigen::Quaterniond& R_CK = Eigen::Quaterniond::Identity());

constexpr double kFinerThanLens = 2;

// Faces so fine that their pixels are at most half of the lens's, by kFinerThanLens: measured on each face
// where the lens is densest, but for a thousandth of the pixels, since a lens may fold at its rim. No side is
// longer than max_side_px, even if a face has to be coarser for that. Faces overlap by enough for
// interpolation; those that the lens does not use are left out. None at all where a ray is 75 degrees or more
// from every axis.
std::optional<LensFaces> PlanFaces(const vision::CameraModel& camera, const FaceLayout& layout,
                                   int max_side_px);
// One plane if it is drawn sooner than a cube.
LensFaces PlanFaces(const vision::CameraModel& camera, int max_side_px);

}  // namespace kestrel::sim
