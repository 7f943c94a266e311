// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "vision/calibration/board/board.h"
#include "vision/calibration/calibration.h"

namespace kestrel::app {

// What was found, for people: parameters with their deviations, residuals of each image, coverage, notes.
std::string CalibrationReport(const vision::Calibration& calibration, const vision::Board& board,
                              std::span<const cv::Mat> images);

// Writes to an existing folder: camchain.yaml, as Kalibr does; report.txt; residuals.png and coverage.png,
// drawn by gnuplot; overlay_NAME.png, the board as the calibration sees it over up to three images, the worst
// among them, with residuals a hundred times as long. images: those of the views. Throws std::runtime_error.
void WriteCalibration(const std::filesystem::path& folder, const vision::Calibration& calibration,
                      const vision::Board& board, std::span<const cv::Mat> images);

}  // namespace kestrel::app
