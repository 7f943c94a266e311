// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "vision/enhance/mosaic/composition.h"
#include "vision/enhance/mosaic/mosaic_series.h"

namespace kestrel::app {

// The name of a file of the mosaic number i of several: mosaic.png, mosaic_2.png, ...
std::string MosaicFile(const std::string& file, int i);

struct WrittenMosaic {
  std::string sentence;  // about it; empty: nothing is in it
  bool whole = true;     // everything that was asked for is written
};
// Composes a mosaic and writes it as a picture, and as a GeoTIFF where that is named and the mosaic has a ground.
// Throws std::runtime_error with the file and the reason.
WrittenMosaic WriteMosaic(const vision::Mosaic& mosaic, int i, const vision::CompositionOptions& options,
                          const std::string& picture_file, const std::string& geotiff_file);

// A row for each image: what became of it, where its middle lies in the end, and on what device points were followed.
std::string MosaicTable(const vision::MosaicSeries& series, const std::vector<double>& times_s,
                        const std::string& device);

}  // namespace kestrel::app
