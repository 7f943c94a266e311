// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace kestrel::vision {

// The row warps of ImageView by images alone. to: from an image to those around it, the same number of images before
// and after, at even times, and itself in the middle. readout: of the rows of one, in intervals of the images. A pixel
// of a row is seen in the other images as late as in this one, and where it is at the middle row's time comes from
// them by a windowed sinc: a shake of up to a half of the rate is undone, not its mean over the interval.
std::vector<Eigen::Matrix3d> RowWarps(const std::vector<Eigen::Matrix3d>& to, double readout);

}  // namespace kestrel::vision
