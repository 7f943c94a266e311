// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/simulated/image_verb.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel track`: a landmark or a ball, in an image, in a video or before a camera.
struct TrackArguments : ImageArguments {
  std::string landmark;
  std::vector<double> size_m;        // of a picture's height and width, or its height alone
  std::vector<std::string> corners;  // "x,y": of the landmark in the first image
  std::vector<std::string> ball;     // "key=value"
  int frames = 0;                    // after so many it ends; 0: with the input
};

CLI::App* AddTrackCommand(CLI::App& app, TrackArguments& arguments);

// Prints a line for an image, or writes a row for each frame. Throws InputError with every mistake of the
// arguments and files, and std::runtime_error if reading or writing fails on the way; then what was tracked until
// then has been written.
void TrackCommand(const TrackArguments& arguments);

}  // namespace kestrel::app
