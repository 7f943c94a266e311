// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <hwy/aligned_allocator.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "vision/camera/camera_model.h"

namespace kestrel::sim::ray {

template <class T>
using Aligned = hwy::AlignedFreeUniquePtr<T[]>;

// The rays of a camera, once for all frames: everything that the renderer needs to know of a camera model.
struct Lens {
  static constexpr int kTile = 16;  // px, both ways: what is tested together for what it may see

  int width = 0, height = 0;
  int stride =
      0;  // of the table: width rounded up to whole tiles, and one more tile for the neighbour of the last

  // The direction of each pixel's centre in C, of length 1, row after row, with one row more than the image.
  // Beyond the edge of the lens and of the image the table goes on linearly for one pixel, so that the
  // difference to the right and to the lower neighbour is the width of a pixel everywhere.
  Aligned<float> x, y, z;
  Aligned<std::uint8_t> inside;  // 1: the lens shows something there; stride as above

  // Each tile is a cone of directions: all of its rays, to the outer edges of its pixels, are within `reach`
  // (a distance on the unit sphere) of the axis. Tiles outside the lens: reach < 0.
  int tiles_x = 0, tiles_y = 0;
  int tiles_padded = 0;  // length of the arrays, for whole vectors
  Aligned<float> axis_x, axis_y, axis_z, reach;
  // Each tile's picture plane, square to its axis: a direction d is at x = d across / d axis, y = d down / d axis. Its
  // pixels are all within low to high, those of each of its columns and rows within that one's. Outside the lens:
  // low > high.
  struct Plane {
    float axis[3], across[3], down[3];  // unit vectors in C
    float low_x, high_x, low_y, high_y;
    bool
        bounded;  // false: some of its rays are square to the axis, or behind it, and the bounds hold nothing
    float column_low_x[kTile], column_high_x[kTile], row_low_y[kTile], row_high_y[kTile];
  };
  std::vector<Plane> planes;  // of the tiles
  float pixel_rad = 0;        // the widest angle between neighbouring pixels
};

Lens MakeLens(const vision::CameraModel& camera);

// The same, and made once for flights of a process that have the same camera.
std::shared_ptr<const Lens> LensOf(const vision::CameraModel& camera);

}  // namespace kestrel::sim::ray
