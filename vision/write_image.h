// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace kestrel::vision {

// Writes an image in the format that the ending of the file's name says, under its final name only once it is
// complete. parameters: cv::ImwriteFlags. Throws std::runtime_error with the file and the reason.
void WriteImage(const std::filesystem::path& file, const cv::Mat& image,
                const std::vector<int>& parameters = {});

}  // namespace kestrel::vision
