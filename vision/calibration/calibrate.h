// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vision/calibration/board/board.h"
#include "vision/calibration/calibration.h"

namespace kestrel::vision {

// Finds a camera of the same model and image size as `like`, whose numbers do not matter, and the pose of the
// board in every view. Starts from many focal lengths and shapes of the lens, so that it holds from 20 to 200
// degrees of view; large errors count less (Huber), and corners more than five deviations off are set aside,
// as is a view with more than a third of such; every view that is not used says why. Corners weigh by their
// covariance. Throws InputError, with what was seen, if the views cannot determine the camera: fewer than
// four different ones, boards all parallel or all in the middle of the image, a focal length that stays open
// by more than a twentieth (a fiftieth of a double sphere), more than a third of the views not of the camera
// of the others; PoorFit if more than accepted_px are left, root mean square (none: AcceptedResidual), as when
// the board's numbers are wrong, the images are of two cameras, or the model is not of this lens.
Calibration Calibrate(const Board& board, std::span<const BoardView> views, const CameraModel& like,
                      std::optional<double> accepted_px = {});

// The views with their corners placed anew by a calibration of them (RefitBoard), for another one; views that
// it did not use stay as they are. images: those of the views. Throws InputError: the discs of a grid of circles are of
// another size, against their spacing, than the board says.
std::vector<BoardView> Refit(const Board& board, std::span<const cv::Mat> images,
                             std::span<const BoardView> views, const Calibration& calibration);

// The models that a calibration can find, by name: "pinhole" (with the distortion of Brown and Conrady),
// "unified", "fisheye" (Kannala and Brandt), "double_sphere".
std::vector<std::string> CalibratedModels();
CameraModel CameraLike(const std::string& model, cv::Size image);

}  // namespace kestrel::vision
