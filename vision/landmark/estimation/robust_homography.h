// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "vision/landmark/plane/homography.h"

// Homographies of pairs among which some are wrong, thesis 3.2.3, beside RansacHomography. The samples depend on
// the seed alone.
namespace kestrel::vision {

struct LmedsOptions {
  double outliers = 0.5;      // epsilon: the share of outliers up to which a good sample is drawn
  double confidence = 0.999;  // p: with this probability
  double max_median_px = 15;  // of the symmetric transfer distance: a larger median is no answer
  int min_inliers = 8;
};

// Least median of squares (Rousseeuw and Leroy 1987): of the samples that one, under which the median of the
// symmetric transfer distances is least. It needs no threshold: the noise follows from that median, and pairs
// within three of its deviations are inliers, to which H is fitted. None: too few of them, or a median above the
// bound, as with outliers of half or more.
std::optional<RobustHomography> LmedsHomography(std::span<const PointPair> pairs, const LmedsOptions& options,
                                                std::uint32_t seed = 1);

// MSAC (Torr and Zisserman 2000) with local optimisation (Chum, Matas and Kittler 2003): of the samples that one,
// under which the sum of the squares of the distances, each at most the threshold's, is least; each that is the
// least so far is first fitted again to what agrees with it, within thresholds that shrink. H makes the symmetric
// transfer error of the inliers least. Options as of RANSAC.
std::optional<RobustHomography> MsacHomography(std::span<const PointPair> pairs, const RansacOptions& options,
                                               std::uint32_t seed = 1);

}  // namespace kestrel::vision
