// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/distortion_terms.h"

#include <cmath>
#include <limits>
#include <utility>

namespace kestrel::vision {

std::vector<int> FreeParameters(const CameraModel& camera) {
  std::vector<int> free;
  const std::vector<std::string> names = ParameterNames(camera);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] != "k3" || std::holds_alternative<KannalaBrandt>(camera)) {
      if (names[i] != "skew") free.push_back(static_cast<int>(i));
    }
  }
  return free;
}

void DropDistortion(const CameraModel& like, Agreeing& agreeing, std::vector<int>& free) {
  std::vector<std::vector<SeenPoint>> points;
  for (const AdjustedView& view : agreeing.adjustment.views) points.push_back(view.points);
  const auto start = StartCalibration(like, kUndistorted, points);
  if (!start) return;
  PlacedViews plain = AdjustRobustly(start->camera, kUndistorted, points);
  if (plain.numbers.size() < points.size()) return;
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const double plain_cost = Adjust(plain.adjustment, {.free = kUndistorted});
  const double cost = CostOf(agreeing.adjustment, kAll), freedom = FreedomOf(agreeing, free.size());
  const double dropped = static_cast<double>(free.size() - kUndistorted.size());
  if (!(plain_cost - cost < dropped * std::log(freedom) * cost / freedom)) return;
  agreeing.adjustment = std::move(plain.adjustment);
  free = kUndistorted;
}

}  // namespace kestrel::vision
