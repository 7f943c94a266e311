// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// What the numbers of a calibration of OpenCV or ROS are those of.
enum class OpenCvModel { kCalibrateCamera, kFisheye, kOmnidir };

// Of a word that OpenCV, ROS, Kalibr, MRPT and their users write, in any case and with any hyphens.
struct ModelWord {
  std::string word;
  std::optional<OpenCvModel> model;  // none: it says nothing of the distortion
};
const ModelWord* FindModelWord(std::string_view written);  // null: not known
Keys AllModelWords();

// The model by every key that names one, which must agree; none: a mistake was added. A wrong guess here is a
// camera that is off by tens of pixels and looks valid, so nothing is guessed.
std::optional<OpenCvModel> OpenCvModelOf(const ConfigNode& root, std::size_t coefficients, Sheet& sheet);

}  // namespace kestrel::vision
