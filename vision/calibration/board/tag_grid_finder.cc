// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/tag_grid_finder.h"

#include <algorithm>
#include <array>
#include <numbers>

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr int kMaxWrongCells = 8;  // of the 100 of a tag that is where it was expected

// The tags of a grid: those that are found by themselves, then, from each to its neighbours, those that are
// where the grid has them.
class GridTracer {
 public:
  GridTracer(const cv::Mat& grey, const Board& board)
      : grey_(grey), board_(board), grid_(std::get<AprilGrid>(board)), map_(board) {}

  CornerMap Trace() {
    const auto tags = FindTags(grey_, grid_.cols * grid_.rows);
    std::vector<int> open;
    for (const SeenTag& tag : tags) {
      if (Place(tag)) open.push_back(tag.id);
    }
    while (!open.empty()) {
      const int id = open.back();
      open.pop_back();
      const int col = id % grid_.cols, row = id / grid_.cols;
      for (const auto& [to_col, to_row] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int c = col + to_col, r = row + to_row;
        if (c < 0 || r < 0 || c >= grid_.cols || r >= grid_.rows || map_.At(2 * c, 2 * r)) continue;
        if (Step(col, row, to_col, to_row)) open.push_back(r * grid_.cols + c);
      }
    }
    return map_;
  }

 private:
  // What is to be expected at corner (c, r) of the grid, which is at (x, y) of a tag's patch.
  std::optional<CornerGuess> GuessIn(const TagPatch& patch, double x, double y, int c, int r) const {
    return GuessOf(board_, c, r, patch.At(x, y), LineIn(patch, grid_.tag_m, x, y, 0),
                   LineIn(patch, grid_.tag_m, x, y, 1), kMinToFind_px);
  }

  // Finds the exact corners of a tag near the rough ones; with all four, it is on the map.
  bool Place(const SeenTag& tag) {
    const int col = tag.id % grid_.cols, row = tag.id / grid_.cols;
    const auto patch = TagPatch::Of(grey_, tag.corners);
    if (!patch) return false;
    SeenTag exact = tag;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = TagCorner(col, row, k);
      const auto guess = GuessIn(*patch, c % 2, r % 2, c, r);
      const double side = std::min((tag.corners[k] - tag.corners[k ^ 1]).norm(),
                                   (tag.corners[k] - tag.corners[3 - k]).norm());
      const auto found = guess ? FindNear(grey_, *guess, std::clamp(0.12 * side, 2.0, 8.0)) : std::nullopt;
      if (!found) return false;
      exact.corners[k] = *found;
    }
    if (WrongCells(grey_, exact) > kMaxWrongCells) return false;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = TagCorner(col, row, k);
      map_.At(c, r) = exact.corners[k];
    }
    return true;
  }

  // From a tag to the next one: across the gap to the near corners, then along both lines to the far ones.
  bool Step(int col, int row, int to_col, int to_row) {
    std::array<Vector2d, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = TagCorner(col, row, k);
      corners[k] = *map_.At(c, r);
    }
    const auto patch = TagPatch::Of(grey_, corners);
    if (!patch) return false;
    SeenTag next;
    const int next_col = col + to_col, next_row = row + to_row, toward = to_col + to_row;
    next.id = next_row * grid_.cols + next_col;
    const auto is_far = [&](int c, int r) { return ((to_col != 0 ? c : r) % 2 == 1) == (toward > 0); };
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = TagCorner(next_col, next_row, k);
      if (is_far(c, r)) continue;
      const Vector2d tag = (map_.Place(c, r) - map_.Place(2 * col, 2 * row)) / grid_.tag_m;
      next.corners[k] = patch->At(tag.x(), tag.y());
      const double side = (corners[0] - corners[2]).norm() / std::numbers::sqrt2;
      const auto guess = GuessIn(*patch, tag.x(), tag.y(), c, r);
      const auto found = guess ? FindNear(grey_, *guess, std::clamp(0.1 * side, 2.0, 6.0)) : std::nullopt;
      if (found) next.corners[k] = *found;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = TagCorner(next_col, next_row, k);
      if (!is_far(c, r)) continue;
      // Lagrange's parabola through the last three corners on the line, of which the nearest was just found.
      const auto on_line = [&, c = c, r = r](int back) {
        return to_col != 0 ? std::pair{c - back * toward, r} : std::pair{c, r - back * toward};
      };
      std::array<double, 3> x;
      std::array<Vector2d, 3> u;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [back_c, back_r] = on_line(static_cast<int>(i) + 1);
        x[i] = map_.Place(back_c, back_r)[to_col != 0 ? 0 : 1];
        u[i] = i == 0 ? next.corners[to_col != 0 ? k ^ 1 : 3 - k] : *map_.At(back_c, back_r);
      }
      const double at = map_.Place(c, r)[to_col != 0 ? 0 : 1];
      next.corners[k].setZero();
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t a = (i + 1) % 3, b = (i + 2) % 3;
        next.corners[k] += (at - x[a]) * (at - x[b]) / ((x[i] - x[a]) * (x[i] - x[b])) * u[i];
      }
    }
    return Place(next);
  }

  const cv::Mat& grey_;
  const Board& board_;
  const AprilGrid& grid_;
  CornerMap map_;
};

}  // namespace

CornerMap FindTagGrid(const cv::Mat& grey, const Board& board) { return GridTracer(grey, board).Trace(); }

}  // namespace kestrel::vision
