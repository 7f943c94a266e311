// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// OpenCV (FileStorage) and ROS: a matrix of 3 x 3 and the coefficients of its distortion, by any of the names that are
// in use; a stereo pair of them; a message camera_info as rostopic prints it (K, D).
Keys OpenCvCameras(const ConfigNode& root);
void FromOpenCv(const ConfigNode& root, std::size_t index, Sheet& sheet);

// OpenCV's 4, 5, 8, 12 or 14 coefficients, as brown_conrady or rational; the mistake names the key of their list.
void SetOpenCvDistortion(const ConfigNode& list, const std::string& key, Sheet& sheet);

}  // namespace kestrel::vision
