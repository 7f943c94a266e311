// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/camera_forms.h"

#include <fmt/format.h>

#include "vision/camera/file/aslam.h"
#include "vision/camera/file/basalt.h"
#include "vision/camera/file/kalibr.h"
#include "vision/camera/file/okvis.h"
#include "vision/camera/file/opencv.h"
#include "vision/camera/file/orb_slam.h"
#include "vision/camera/file/vins.h"

namespace kestrel::vision {

const std::vector<CameraForm>& CameraForms() {
  static const std::vector<CameraForm> kForms{
      {"Kalibr", "resolution", KalibrCameras, FromKalibr},
      {"Basalt", "resolution", BasaltCameras, FromBasalt},
      {"SVO or maplab", "image_width, image_height", AslamCameras, FromAslam},
      {"EuRoC", "resolution", EurocCameras, FromEuroc},
      {"OKVIS", "image_dimension", OkvisCameras, FromOkvis},
      {"VINS", "image_width, image_height", VinsCameras, FromVins},
      {"ORB-SLAM", "Camera.width, Camera.height", OrbSlamCameras, FromOrbSlam},
      {"OpenCV or ROS", "image_width, image_height", OpenCvCameras, FromOpenCv}};
  return kForms;
}

const CameraForm* FindForm(const ConfigNode& root) {
  for (const CameraForm& each : CameraForms()) {
    if (!each.cameras(root).empty()) return &each;
  }
  return nullptr;
}

Keys NumberedCameras(std::size_t count) {
  Keys names;
  for (std::size_t i = 0; i < count; ++i) names.push_back(fmt::format("cam{}", i));
  return names;
}

}  // namespace kestrel::vision
