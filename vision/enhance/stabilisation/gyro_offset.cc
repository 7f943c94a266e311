// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/gyro_offset.h"

#include <algorithm>
#include <cmath>

#include "geometry/pose.h"

namespace kestrel::vision {
namespace {

constexpr int kLeastTurns = 20;
constexpr double kLike = 0.5;

std::optional<GyroOffset> Compare(const std::vector<ImageTurn>& turns, const GyroTrack& gyro,
                                  double offset_s) {
  GyroOffset result{offset_s, 0, 0};
  std::vector<Eigen::Vector3d> seen, felt;
  Eigen::Vector3d mean_seen = Eigen::Vector3d::Zero(), mean_felt = Eigen::Vector3d::Zero();
  for (const ImageTurn& turn : turns) {
    const auto from = gyro.At(turn.from_s + offset_s), to = gyro.At(turn.to_s + offset_s);
    if (!from || !to || !(turn.to_s > turn.from_s)) continue;
    // Rates, less their means: a bias is none of the clock's.
    const double dt_s = turn.to_s - turn.from_s;
    seen.push_back(turn.turn / dt_s), felt.push_back(LogRotation(from->conjugate() * *to) / dt_s);
    mean_seen += seen.back(), mean_felt += felt.back();
  }
  result.turns = static_cast<int>(seen.size());
  if (result.turns < kLeastTurns) return std::nullopt;
  mean_seen /= result.turns, mean_felt /= result.turns;
  double rest = 0, all = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    rest += (seen[i] - mean_seen - (felt[i] - mean_felt)).squaredNorm();
    all += (seen[i] - mean_seen).squaredNorm();
  }
  if (!(all > 0)) return std::nullopt;
  result.unlike = std::sqrt(rest / all);
  return result;
}

}  // namespace

std::optional<GyroOffset> EstimateGyroOffset(const std::vector<ImageTurn>& turns, const GyroTrack& gyro,
                                             double max_offset_s) {
  constexpr double kCoarse_s = 0.01, kFinest_s = 1e-4;
  std::optional<GyroOffset> best;
  std::vector<GyroOffset> coarse;
  const auto search = [&](double from_s, double to_s, double step_s) {
    const int steps = static_cast<int>(std::lround((to_s - from_s) / step_s));
    for (int i = 0; i <= steps; ++i) {
      const auto at = Compare(turns, gyro, from_s + i * step_s);
      if (at && step_s == kCoarse_s) coarse.push_back(*at);
      if (at && (!best || at->unlike < best->unlike)) best = at;
    }
  };
  search(-max_offset_s, max_offset_s, kCoarse_s);
  for (double step_s = kCoarse_s / 5; best && step_s > kFinest_s; step_s /= 5)
    search(best->offset_s - 5 * step_s, best->offset_s + 5 * step_s, step_s);
  if (!best || best->unlike > kLike) return std::nullopt;
  constexpr double kApart_s = 0.05, kAsGood = 0.15;
  double least = std::min(best->unlike + kAsGood, kLike);
  for (std::size_t i = 1; i + 1 < coarse.size(); ++i) {
    const double here = coarse[i].unlike;
    if (std::abs(coarse[i].offset_s - best->offset_s) < kApart_s || here > least ||
        here > coarse[i - 1].unlike || here > coarse[i + 1].unlike)
      continue;
    least = here, best->other_s = coarse[i].offset_s;
  }
  return best;
}

}  // namespace kestrel::vision
