// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "bench/enhance/shaken_clip.h"
#include "vision/enhance/stabilisation/stabiliser_options.h"

namespace kestrel::bench {

// Before and after, side by side: the image in the middle of the clip, with what was matched (NAME.jpg), and the mean
// of a second of images about it, which is sharp where nothing shakes and the camera stands (NAME_second.jpg).
void WriteStabiliseStills(const ShakenClip& clip, const std::vector<cv::Mat>& images,
                          const vision::StabiliserOptions& options, const std::string& name,
                          const std::filesystem::path& out);

}  // namespace kestrel::bench
