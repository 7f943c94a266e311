// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "bench/horizon/horizon_judgement.h"

namespace kestrel::bench {

// errors.png: the error of each still against height, tilt, ridge and haze, with its median and its 95th
// percentile, alone and expecting; outcomes.png: what became of the stills of each range of a factor;
// normalised_errors.png: errors in their stated deviations beside the normal distribution.
void DrawHorizonBench(const std::filesystem::path& folder, const std::vector<JudgedStill>& all);

// One still as DrawHorizon has it, with the true horizon in white and what it was.
cv::Mat DrawStill(const cv::Mat& image, const vision::CameraModel& camera, const Pose& X_BC,
                  const JudgedStill& still, std::size_t index, Way way, const vision::SkylineResult& result);
// Pictures of one size, three in a row.
void WriteSheet(const std::filesystem::path& file, const std::vector<cv::Mat>& pictures);

}  // namespace kestrel::bench
