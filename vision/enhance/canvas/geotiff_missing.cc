// SPDX-License-Identifier: Apache-2.0
// Without libtiff.
#include <stdexcept>

#include "vision/enhance/canvas/geotiff.h"

namespace kestrel::vision {

bool GeoTiffIsAvailable() { return false; }

void WriteGeoTiff(const std::filesystem::path& file, const MosaicPicture&, const Eigen::Matrix3d&) {
  throw std::runtime_error(file.string() +
                           ": this build has no GeoTIFF; install libtiff-dev and build again");
}

}  // namespace kestrel::vision
