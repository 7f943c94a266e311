// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// A camchain of Kalibr, also as OpenVINS and MSCKF have it: cam0, cam1, ... with camera_model and
// distortion_model.
Keys KalibrCameras(const ConfigNode& root);
void FromKalibr(const ConfigNode& root, std::size_t index, Sheet& sheet);

// sensor.yaml of one camera of a EuRoC folder, also as TUM-VI and others write it, in Kalibr's words: camera_model,
// intrinsics, distortion_model and distortion_coefficients at its top; T_BS is the camera's pose on the body,
// which is the IMU.
Keys EurocCameras(const ConfigNode& root);
void FromEuroc(const ConfigNode& root, std::size_t index, Sheet& sheet);

// Kalibr's names of a model, ours, and the order of its numbers.
struct KalibrForm {
  const char *camera_model, *distortion_model, *model;
  Keys intrinsics, distortion;
};
const std::vector<KalibrForm>& KalibrForms();

}  // namespace kestrel::vision
