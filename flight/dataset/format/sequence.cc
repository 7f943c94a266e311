// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/format/sequence.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kestrel::flight {

RigCamera MakeRigCamera(const vision::CameraModel& model, const Pose& X_BC, double rate_hz) {
  RigCamera camera{model, X_BC, rate_hz, cv::Mat(vision::HeightPx(model), vision::WidthPx(model), CV_32F)};
  camera.axial.forEach<float>([&](float& share, const int* at) {
    const auto ray = vision::Ray(model, Eigen::Vector2d(at[1], at[0]));
    share = ray ? static_cast<float>(ray->z()) : 0;
  });
  return camera;
}

void MergeTruth(const std::vector<TruthRow>& others, Sequence& s) {
  std::vector<TruthRow> all;
  std::merge(s.truth.begin(), s.truth.end(), others.begin(), others.end(), std::back_inserter(all),
             [](const TruthRow& a, const TruthRow& b) { return a.stamp_ns < b.stamp_ns; });
  const auto last = std::unique(
      all.begin(), all.end(), [](const TruthRow& a, const TruthRow& b) { return a.stamp_ns == b.stamp_ns; });
  all.erase(last, all.end());
  s.truth = std::move(all);
}

}  // namespace kestrel::flight
