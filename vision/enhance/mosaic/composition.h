// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::vision {

// What a mosaic may be composed by when it is complete: the three blendings of thesis 4.3, and what goes beyond.
enum class Composer {
  kAverage,
  kFeather,
  kNearest,
  kMedian,    // of each channel over all images: what moves is seen in few of them and vanishes
  kSeams,     // images are cut where they differ least, so that what moves is seen once or not at all
  kMultiBand  // the same, and joined the more widely the coarser the detail (Burt and Adelson 1983)
};

struct CompositionOptions {
  Composer composer = Composer::kMultiBand;
  bool exposure = true;  // gains that make images agree where they overlap (Brown and Lowe 2007)
  std::int64_t most_bytes = 2'000'000'000;  // beyond, it is scaled down by halves
};

// The mosaic anew from the images that it keeps, where its adjustment has placed them. Gains, seams and the blending
// of bands are those of OpenCV's stitching. The same mosaic gives the same bits on any number of threads.
MosaicPicture Compose(const Mosaic& mosaic, const CompositionOptions& options);

}  // namespace kestrel::vision
