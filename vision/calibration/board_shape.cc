// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kestrel::vision {
namespace {

constexpr double kFirstExpected = 0.01;  // offsets over the distance between neighbouring corners
constexpr double kLeastExpected_m = 1e-7;
constexpr double kEveryError = std::numeric_limits<double>::infinity();

}  // namespace

bool FindBoardShape(const Board& board, Agreeing& agreeing, const std::vector<int>& free) {
  const std::vector<Eigen::Vector2d> places = Corners(board);
  const double expected_m = kFirstExpected * (places[1] - places[0]).norm();
  Agreeing freed = agreeing;
  freed.adjustment.board = {std::vector<Eigen::Vector3d>(places.size(), Eigen::Vector3d::Zero()), expected_m,
                            expected_m};
  Adjust(freed.adjustment, {.free = free});
  const double determined = DeterminedOffsets(freed.adjustment, free).sum();
  const double cost = CostOf(freed.adjustment, kEveryError) - CostOf(freed.adjustment.board);
  const double freedom = FreedomOf(agreeing, free.size()) - determined;
  const double gain = CostOf(agreeing.adjustment, kEveryError) - cost;
  if (!(freedom > 0) || !(gain > determined * std::log(freedom) * cost / freedom)) return false;
  agreeing = std::move(freed);
  return true;
}

void AdjustBoardShape(Agreeing& agreeing, const std::vector<int>& free) {
  BoardShape& board = agreeing.adjustment.board;
  const Eigen::Vector2d determined = DeterminedOffsets(agreeing.adjustment, free);
  double in_plane = 0, out_of_plane = 0;
  for (const Eigen::Vector3d& offset : board.offsets_m)
    in_plane += offset.head<2>().squaredNorm(), out_of_plane += offset.z() * offset.z();
  board.in_plane_m = std::max(std::sqrt(in_plane / std::max(determined.x(), 1.0)), kLeastExpected_m);
  board.out_of_plane_m = std::max(std::sqrt(out_of_plane / std::max(determined.y(), 1.0)), kLeastExpected_m);
  Adjust(agreeing.adjustment, {.free = free});
}

Eigen::Vector2d RmsOf(const BoardShape& board) {
  double in_plane = 0, out_of_plane = 0;
  for (const Eigen::Vector3d& offset : board.offsets_m)
    in_plane += offset.head<2>().squaredNorm(), out_of_plane += offset.z() * offset.z();
  const double count = static_cast<double>(std::max<std::size_t>(board.offsets_m.size(), 1));
  return {std::sqrt(in_plane / count), std::sqrt(out_of_plane / count)};
}

}  // namespace kestrel::vision
