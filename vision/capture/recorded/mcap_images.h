// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "base/diagnostics.h"
#include "vision/capture/recorded/recorded_images.h"

namespace kestrel::vision {

// Whether a file is named or begins as an MCAP.
bool IsMcap(const std::filesystem::path& file);

// The images of one topic of an MCAP of ROS 2: sensor_msgs/Image (raw_image.h) or CompressedImage. topic: empty:
// the only one that has images. In the order of the log, by the stamps of their headers; where all of these are
// 0, by when they were logged, which is noted.
//
// Of a file that was cut, or is damaged, the images are those that are whole; what is missing is noted. No such
// topic, several of which none is named, one without messages, a message that is none, and a stamp that repeats
// or goes back are mistakes.
RecordedImages OpenMcapImages(const std::filesystem::path& file, const std::string& topic,
                              Mistakes& mistakes);

}  // namespace kestrel::vision
