// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "vision/calibration/board/board.h"
#include "vision/calibration/calibration.h"

// What a calibration is refused for. Each throws InputError with what was seen and a remedy.
namespace kestrel::vision {

inline constexpr std::size_t kMinViews = 4;

// Views that cannot determine a camera, whatever it is.
void CheckViews(const Board& board, std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                const CameraModel& like);

// A camera that is only of some of the images. left_out: of the usable views, why; empty: it is not.
void CheckLeftOut(std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                  const std::vector<std::string>& left_out, const CameraModel& like);

// What may be left between a camera and what its images show, root mean square, px: a thousandth of the
// image's diagonal, 0.8 px of 640 x 480. What is left of a good calibration is mostly of the board (its print,
// its bend), which more pixels see larger. Where edges are blurred by more than 0.7 px, the median of the
// corners, as much more as they are: then pixels are finer than the picture.
double AcceptedResidual(std::span<const BoardView> views, const CameraModel& like);

// A camera that leaves more than accepted_px: throws PoorFit.
void CheckResidual(const Calibration& calibration, double accepted_px);

// Parameters that the views leave open, though they may say well where rays go.
void CheckFocalLength(const Calibration& calibration);

// What else to try for views that leave the parameters of a model open.
const char* RemedyFor(const CameraModel& camera);

}  // namespace kestrel::vision
