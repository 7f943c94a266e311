// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "vision/enhance/canvas/canvas.h"

namespace kestrel::vision {

// Whether this build can write one: it needs libtiff.
bool GeoTiffIsAvailable();

// A mosaic as a GeoTIFF (OGC 19-008r4): its image with an alpha channel, ModelTransformation's simple form of
// ModelPixelScale and ModelTiepoint, and a local coordinate system of metres, x east and y north from the origin of
// N. ground: takes (u, v, 1) of the surface to (x north, y east, 1) of N, with v to the south and u to the east, as
// Mosaic::GroundFromSurface gives it. The file appears when it is complete. Throws std::runtime_error with the
// file and the reason.
void WriteGeoTiff(const std::filesystem::path& file, const MosaicPicture& picture,
                  const Eigen::Matrix3d& ground);

}  // namespace kestrel::vision
