// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

double ShareCovered(const CameraModel& camera) {
  // From the centre of the first pixel to that of the last, corners included: those stand for less.
  constexpr int kSteps = 64;
  const auto weight = [](int i) { return i == 0 || i == kSteps ? 0.5 : 1.0; };
  double seen = 0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d uv((WidthPx(camera) - 1.0) * i / kSteps, (HeightPx(camera) - 1.0) * j / kSteps);
      if (Ray(camera, uv)) seen += weight(i) * weight(j);
    }
  }
  return seen / (kSteps * kSteps);
}

}  // namespace kestrel::vision
