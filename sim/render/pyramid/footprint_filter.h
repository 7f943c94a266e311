// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace kestrel::sim::ray {

// Weights of a texel and of those 1, 2 and 3 away on either side of it, in 4096ths; all seven together: 4096.
using FootprintFilter = std::array<int, 4>;

// Makes of a picture one that is nearest to the mean over a pixel's footprint where it is interpolated between its
// texels: interpolation blurs by itself, so that where a footprint is little more than a texel this filter sharpens.
// footprint: its side in texels, from 1 to 2. original: the picture itself, which is interpolated between its texels by
// definition; otherwise a smaller one, whose texels are means over squares of it.
FootprintFilter FilterFor(double footprint, bool original);

// Rows of a picture of one or three channels of 8 bits, filtered across and down. repeats: beyond its edge it begins
// anew; otherwise the texels at the edge go on.
cv::Mat Filtered(const cv::Mat& picture, cv::Range rows, const FootprintFilter& filter, bool repeats);

}  // namespace kestrel::sim::ray
