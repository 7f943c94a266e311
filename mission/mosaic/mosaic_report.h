// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "mission/path/path_pilot.h"
#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::mission {

// An image of a mosaic, and where it came to lie: M_WC takes its rays to directions in W (vision/enhance/mosaic).
struct PlacedImage {
  std::int64_t sequence = 0;  // of its frame
  Eigen::Matrix3d M_WC = Eigen::Matrix3d::Identity();
};

// A mosaic at its end, without its pixels.
struct FinishedMosaic {
  vision::Projection projection;
  std::vector<PlacedImage> placed;   // in the order of time
  std::vector<PlacedImage> chained;  // by a second mosaic that closes no loops; empty: none was made
  std::optional<Eigen::Matrix3d> ground_from_surface;  // as Mosaic::GroundFromSurface
};

// The report of missions that make a mosaic.
struct MosaicReport final : PathReport {
  std::optional<vision::MosaicStep> step;                 // of this frame; none: it was not asked for
  int offered = 0, placed = 0, keyframes = 0, loops = 0;  // until now
  std::shared_ptr<const FinishedMosaic> finished;         // of the last frame alone
};

}  // namespace kestrel::mission
