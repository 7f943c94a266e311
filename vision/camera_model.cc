// SPDX-License-Identifier: Apache-2.0
#include "vision/camera_model.h"

namespace kestrel {

double ShareCovered(const CameraModel& camera) {
  constexpr int kSteps = 64;
  int seen = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      // From the centre of the first pixel to that of the last, corners included.
      const Eigen::Vector2d uv((WidthPx(camera) - 1.0) * i / (kSteps - 1),
                               (HeightPx(camera) - 1.0) * j / (kSteps - 1));
      seen += Ray(camera, uv).has_value();
    }
  }
  return seen / static_cast<double>(kSteps * kSteps);
}

}  // namespace kestrel
