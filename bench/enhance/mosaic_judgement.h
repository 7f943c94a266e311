// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "bench/enhance/mosaic_drawings.h"
#include "vision/enhance/mosaic/mosaic.h"

namespace kestrel::bench {

struct SurveyErrors {
  // RMS over 200 points of the ground, by where their images were placed.
  double placed_px = 0;
  // RMS over 200 corners of the orthographic drawing, by where the picture looks like them. One that is not found
  // counts with 40 px, which is as far as it is looked for.
  double picture_px = 0;
  int points = 0;  // that were found in the picture
};

// How far the points of a mosaic are from where they are on the ground, in pixels of the mosaic. without_poses: it is
// known up to a homography, which is fitted first; otherwise by GroundFromSurface alone. drawn: where the picture in the
// frame of the orthographic drawing is left.
SurveyErrors JudgeSurvey(const DrawnSurvey& survey, const vision::Mosaic& mosaic,
                         const vision::MosaicPicture& picture, bool without_poses, std::uint64_t seed,
                         cv::Mat* drawn = nullptr);

struct TurnErrors {
  double closure_deg =
      0;  // between the places of one direction, by the first image that sees it and by the last
  double direction_deg = 0;  // RMS over 200 directions, after the rotation by which all are off
};
TurnErrors JudgeTurn(const DrawnTurn& turn, const vision::Mosaic& mosaic, std::uint64_t seed);

}  // namespace kestrel::bench
