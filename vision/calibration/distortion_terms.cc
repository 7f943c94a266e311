// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/distortion_terms.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace kestrel::vision {
namespace {

constexpr double kAllErrors = std::numeric_limits<double>::infinity();

// Indices of parameters that stand or fall together, in the order in which they are tried.
struct DistortionGroups {
  std::vector<std::vector<int>> groups;
  bool only_the_last = false;  // of a power series the highest term alone may be held
};

DistortionGroups GroupsOf(const CameraModel& camera) {
  if (std::holds_alternative<BrownConrady>(camera)) return {{{5}, {6, 7}, {4}}};
  if (std::holds_alternative<KannalaBrandt>(camera)) return {{{7}, {6}, {5}, {4}}, true};
  if (std::holds_alternative<Unified>(camera)) return {{{5, 6, 7, 8}, {5, 6}, {7, 8}}};
  return {};
}

std::vector<int> Without(const std::vector<int>& free, const std::vector<int>& group) {
  std::vector<int> left;
  for (const int i : free) {
    if (std::find(group.begin(), group.end(), i) == group.end()) left.push_back(i);
  }
  return left;
}

// How much larger the variance of these parameters is than by independent corners, in the mean; 1 at least.
double DesignEffect(const Agreeing& agreeing, const std::vector<int>& free, const std::vector<int>& group,
                    double variance) {
  const auto independent = ParameterCovariance(agreeing.adjustment, free);
  const auto clustered = ClusteredCovariance(agreeing.adjustment, free);
  if (!independent || !clustered) return 1;
  std::vector<Eigen::Index> at;
  for (const int i : group) at.push_back(std::find(free.begin(), free.end(), i) - free.begin());
  const Eigen::MatrixXd one = variance * (*independent)(at, at), other = (*clustered)(at, at);
  const Eigen::VectorXd scale = one.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd ratio = (scale.asDiagonal() * one * scale.asDiagonal())
                                    .lu()
                                    .solve(scale.asDiagonal() * other * scale.asDiagonal());
  return std::max(1.0, ratio.trace() / static_cast<double>(group.size()));
}

// The best camera with these parameters alone, of the same corners. None: some view has no pose then.
std::optional<Adjustment> Restricted(const CameraModel& like, const Agreeing& agreeing,
                                     const std::vector<int>& free, const std::vector<int>& held) {
  std::vector<std::vector<SeenPoint>> points;
  for (const AdjustedView& view : agreeing.adjustment.views) points.push_back(view.points);
  CameraModel camera = agreeing.adjustment.camera;
  if (std::holds_alternative<Unified>(like)) {  // elsewhere along the valley of xi and k1
    const auto start = StartCalibration(like, free, points);
    if (!start) return std::nullopt;
    camera = start->camera;
  } else {
    Eigen::VectorXd all = Parameters(camera);
    for (const int i : held) all[i] = 0;
    SetParameters(camera, all);
  }
  PlacedViews placed = AdjustRobustly(camera, free, points);
  if (placed.numbers.size() < points.size()) return std::nullopt;
  placed.adjustment.board = agreeing.adjustment.board;
  Adjust(placed.adjustment, {.free = free});
  return std::move(placed.adjustment);
}

}  // namespace

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
  const DistortionGroups groups = GroupsOf(like);
  for (const std::vector<int>& group : groups.groups) {
    const std::vector<int> without = Without(free, group);
    if (without.size() + group.size() != free.size()) continue;  // some of it is held already
    auto plain = Restricted(like, agreeing, without, group);
    const double cost = CostOf(agreeing.adjustment, kAllErrors), freedom = FreedomOf(agreeing, free.size());
    const double wanted = static_cast<double>(group.size()) * std::log(freedom) * cost / freedom *
                          DesignEffect(agreeing, free, group, cost / freedom);
    if (plain && CostOf(*plain, kAllErrors) - cost < wanted) {
      agreeing.adjustment = std::move(*plain);
      free = without;
    } else if (groups.only_the_last) {
      break;
    }
  }
}

std::string HeldDistortion(const CameraModel& camera, const std::vector<int>& free) {
  std::string held;
  const std::vector<std::string> names = ParameterNames(camera);
  for (const int i : FreeParameters(camera)) {
    if (std::find(free.begin(), free.end(), i) == free.end())
      held += (held.empty() ? "" : ", ") + names[static_cast<std::size_t>(i)];
  }
  return held;
}

}  // namespace kestrel::vision
