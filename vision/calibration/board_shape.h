// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/calibration/agreeing_views.h"

// The true board beside the one of its file. A print on paper is uneven and bent by some tenths of a millimetre;
// a camera that is fitted to a flat, even board takes that for its own distortion (Strobl and Hirzinger, "More
// accurate pinhole camera calibration with imperfect planar target", ICCV workshops 2011).
namespace kestrel::vision {

// Frees the corners of the board and adjusts camera, poses and board together, if the images ask for it: if the
// sum of squares falls by more than Schwarz's criterion wants of as many parameters as are determined then.
// Otherwise changes nothing. Whether it did.
bool FindBoardShape(const Board& board, Agreeing& agreeing, const std::vector<int>& free);

// Adjusts once more, after what is expected of the offsets is set to what they are.
void AdjustBoardShape(Agreeing& agreeing, const std::vector<int>& free);

// Root mean square of the offsets, in the plane of the board and out of it, m.
Eigen::Vector2d RmsOf(const BoardShape& board);

}  // namespace kestrel::vision
