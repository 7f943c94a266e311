// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>
#include <stdexcept>
#include <string>

#include "app/simulated/image_verb.h"
#include "base/diagnostics.h"

namespace kestrel::app {

// An image of a folder that cannot be read. It has its time; the next one can be taken.
struct UnreadableImage : std::runtime_error {
  UnreadableImage(const std::string& why, double at_s) : std::runtime_error(why), t_s(at_s) {}
  double t_s;
};

// --deinterlace.
void AddDeinterlaceOption(CLI::App& command, ImageArguments& arguments);

// --topic and --rate.
void AddRecordingOptions(CLI::App& command, ImageArguments& arguments);

// What `input` names: an image, a video, a recording (vision/capture/recorded/recorded_images.h), be it a data set
// or a folder of images in the order of their names, or a camera's address. A video whose images change their size
// is a mistake, since it would be scaled without a word; those of a recording come as they are. The images of a
// recording have its stamps, which is noted; without them, and of a video, they are 1 / rate_hz apart; those of a
// video of variable rate as the file says, which is noted, and a camera's have the times of the monotonic clock. A camera's next() ends soon after `stopped` is set, and it is to outlive the input. next() throws
// UnreadableImage of one of a folder, and std::runtime_error where a video cannot be read on.
//
// With `deinterlace`, the images are those of the first field alone.
ImageInput OpenImages(const ImageArguments& arguments, const std::atomic<bool>& stopped, Mistakes& mistakes);

// The next image, this number counted from 0; an empty one where it cannot be read, which is told unless `quiet`.
std::optional<vision::Frame> NextImage(ImageInput& input, int number, bool quiet);

}  // namespace kestrel::app
