// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>

#include "base/diagnostics.h"
#include "vision/capture/aravis_source.h"
#include "vision/capture/folder_source.h"
#include "vision/capture/image_source.h"
#include "vision/capture/opencv_source.h"

namespace kestrel::vision {

// What a person writes to name a camera: see CameraAddressForms().
using CameraAddress = std::variant<OpenCvSourceOptions, AravisSourceOptions, FolderSourceOptions>;

// Throws InputError with every mistake and what would be valid. A file or folder must be there; whether a
// camera is, only opening it tells.
CameraAddress ParseCameraAddress(const std::string& address);
Place PlaceOfCamera(const std::string& address);  // of its mistakes

ImageSourceMaker SourceAt(const CameraAddress& address);

// The size that the images must have; empty: none was given.
cv::Size SizeAt(const CameraAddress& address);

// One line for each form, and the options: for the help of the command line.
std::string CameraAddressForms();

}  // namespace kestrel::vision
