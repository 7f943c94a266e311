// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/board_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/diagnostics.h"
#include "vision/calibration/board/chessboard_finder.h"
#include "vision/calibration/board/corner_fit.h"
#include "vision/calibration/board/tag_finder.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

// Around a corner, free of anything else: to place it well, and to find it at all.
constexpr double kMinClear_px = 3.2, kMinToFind_px = 2;
constexpr double kMinRadius_px = 2.5, kMaxRadius_px = 7;
constexpr Eigen::Index kMaxDegree = 4;  // of the polynomial along a line of corners
constexpr int kMaxWrongCells = 8;       // of the 100 of a tag that is where it was expected

// Where the corners of a board have been seen so far: by row and column of its grid.
class CornerMap {
 public:
  explicit CornerMap(const Board& board)
      : grid_(CornerGrid(board)), places_(Corners(board)), seen_(places_.size()) {}

  int cols() const { return grid_.x(); }
  int rows() const { return grid_.y(); }
  const Vector2d& Place(int col, int row) const { return places_[Index(col, row)]; }
  std::optional<Vector2d>& At(int col, int row) { return seen_[Index(col, row)]; }
  const std::optional<Vector2d>& At(int col, int row) const { return seen_[Index(col, row)]; }
  std::size_t Index(int col, int row) const { return static_cast<std::size_t>(row * grid_.x() + col); }

  // How the image of the line through a corner along axis 0 (x) or 1 (y) of the board runs there: its
  // derivatives by the board's coordinate, px/m and px/m^2, of the polynomial through it and the nearest
  // others on it; with a single one, the first alone.
  struct Line {
    Vector2d tangent, second = Vector2d::Zero();
    bool bend_known = false;
  };
  std::optional<Line> LineAt(int col, int row, int axis) const {
    if (!At(col, row)) return std::nullopt;
    std::vector<std::pair<double, Vector2d>> others;  // from this corner, m and px
    const int count = axis == 0 ? cols() : rows();
    for (int i = 0; i < count; ++i) {
      const int c = axis == 0 ? i : col, r = axis == 0 ? row : i;
      if ((c == col && r == row) || !At(c, r)) continue;
      others.emplace_back((Place(c, r) - Place(col, row))[axis], *At(c, r) - *At(col, row));
    }
    if (others.empty()) return std::nullopt;
    std::sort(others.begin(), others.end(),
              [](const auto& a, const auto& b) { return std::abs(a.first) < std::abs(b.first); });
    const Eigen::Index degree = std::min<Eigen::Index>(kMaxDegree, static_cast<Eigen::Index>(others.size()));
    // u(x) / x = tangent + second / 2 x + ...; x in units of the farthest, for the numbers' sake.
    const double unit = std::abs(others[static_cast<std::size_t>(degree - 1)].first);
    Eigen::MatrixXd powers(degree, degree), slopes(degree, 2);
    for (Eigen::Index i = 0; i < degree; ++i) {
      const auto& [x, u] = others[static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j < degree; ++j) powers(i, j) = std::pow(x / unit, j);
      slopes.row(i) = u.transpose() / x;
    }
    const Eigen::MatrixXd fit = powers.partialPivLu().solve(slopes);
    if (degree == 1) return Line{fit.row(0)};
    return Line{fit.row(0), 2 * fit.row(1) / unit, true};
  }

 private:
  Eigen::Vector2i grid_;
  std::vector<Vector2d> places_;
  std::vector<std::optional<Vector2d>> seen_;
};

// Of the quarters around a corner: whether that between +x and +y is black. And how far along x and y of the
// board nothing else is seen, m.
struct Surroundings {
  bool black_between = false;
  Vector2d clear_m;
};
Surroundings SurroundingsOf(const Board& board, int col, int row) {
  if (const Chessboard* c = std::get_if<Chessboard>(&board))
    return {(row + col) % 2 == 0, {c->col_m, c->row_m}};
  const AprilGrid& grid = std::get<AprilGrid>(board);
  const double clear = std::min(0.2, grid.spacing) * grid.tag_m;  // the tag's border, or the gap
  return {(row + col) % 2 == 0, {clear, clear}};
}

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// The curvature of an edge, 1/px, towards the side where the other axis lies.
double Bend(const CornerMap::Line& line, const Vector2d& other) {
  const double length = line.tangent.norm();
  return Cross(line.tangent, line.second) / (length * length * length) *
         (Cross(line.tangent, other) > 0 ? 1 : -1);
}

// What is to be expected at a corner whose lines are known. None: too small to be placed.
std::optional<CornerGuess> GuessOf(const Board& board, int col, int row, const Vector2d& pixel,
                                   const CornerMap::Line& x, const CornerMap::Line& y, double least_clear_px,
                                   bool black_lower_left = true) {
  const Surroundings around = SurroundingsOf(board, col, row);
  const Vector2d a = x.tangent * around.clear_m.x(), b = y.tangent * around.clear_m.y();
  const double clear = std::abs(Cross(a, b)) / std::max({a.norm(), b.norm(), 1e-12});
  if (!(clear >= least_clear_px)) return std::nullopt;
  return CornerGuess{pixel,
                     x.tangent,
                     y.tangent,
                     Bend(x, y.tangent),
                     Bend(y, x.tangent),
                     around.black_between == black_lower_left,
                     std::clamp(clear - 1, kMinRadius_px, kMaxRadius_px)};
}

// Corner k of a tag in the grid of corners.
std::pair<int, int> TagCorner(int tag_col, int tag_row, std::size_t k) {
  return {2 * tag_col + (k == 1 || k == 2 ? 1 : 0), 2 * tag_row + (k > 1 ? 1 : 0)};
}

// How the line along an axis runs at a place of a tag's patch, by differences of it.
CornerMap::Line LineIn(const TagPatch& patch, double side_m, double x, double y, int axis) {
  constexpr double kStep = 0.1;
  const Vector2d step = kStep * Vector2d::Unit(axis);
  const Vector2d before = patch.At(x - step.x(), y - step.y()), at = patch.At(x, y);
  const Vector2d after = patch.At(x + step.x(), y + step.y());
  const double step_m = kStep * side_m;
  return {(after - before) / (2 * step_m), (after - 2 * at + before) / (step_m * step_m), true};
}

// By the corners on the line; where these are too few, as of a tag that has no neighbour there, by the tag's
// own sides.
std::optional<CornerMap::Line> LineAt(const cv::Mat& grey, const Board& board, const CornerMap& map, int col,
                                      int row, int axis) {
  const auto line = map.LineAt(col, row, axis);
  const AprilGrid* grid = std::get_if<AprilGrid>(&board);
  if (!line || line->bend_known || !grid) return line;
  std::array<Vector2d, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto [c, r] = TagCorner(col / 2, row / 2, k);
    if (!map.At(c, r)) return line;
    corners[k] = *map.At(c, r);
  }
  const auto patch = TagPatch::Of(grey, corners);
  return patch ? LineIn(*patch, grid->tag_m, col % 2, row % 2, axis) : line;
}

// Fits a corner; once more within a smaller radius where what stands around it spreads by the blur.
std::optional<FittedCorner> FitFree(const cv::Mat& grey, CornerGuess guess) {
  const auto fit = FitCorner(grey, guess);
  if (!fit) return std::nullopt;
  const double free_px = std::max(guess.radius_px + 1 - 2 * fit->blur_px, kMinRadius_px);
  if (free_px >= guess.radius_px) return fit;
  guess.pixel = fit->pixel;
  guess.radius_px = free_px;
  return FitCorner(grey, guess);
}

// Fits every corner of the map. Thrice, since the curvature of the edges is known only once their corners
// are; a corner where it is never known is left out, as is one that cannot be fitted.
std::vector<BoardCorner> FitAll(const cv::Mat& grey, const Board& board, CornerMap map,
                                bool black_lower_left) {
  std::vector<BoardCorner> corners;
  for (int pass = 0; pass < 3; ++pass) {
    corners.clear();
    CornerMap fitted = map;
    for (int row = 0; row < map.rows(); ++row) {
      for (int col = 0; col < map.cols(); ++col) {
        fitted.At(col, row).reset();
        const auto x = LineAt(grey, board, map, col, row, 0), y = LineAt(grey, board, map, col, row, 1);
        if (!x || !y) continue;
        auto guess = GuessOf(board, col, row, *map.At(col, row), *x, *y, kMinClear_px, black_lower_left);
        if (!guess) continue;
        if (pass == 0) guess->bend_x = guess->bend_y = 0;
        const auto fit = FitFree(grey, *guess);
        if (!fit) continue;
        fitted.At(col, row) = fit->pixel;
        if (x->bend_known && y->bend_known)
          corners.push_back({static_cast<int>(map.Index(col, row)), fit->pixel, fit->covariance,
                             black_lower_left, fit->blur_px});
      }
    }
    map = fitted;
  }
  return corners;
}

// A whole chessboard. In the order of Corners.
std::optional<CornerMap> FindChessboard(const cv::Mat& grey, const Board& board, const Chessboard& chess,
                                        bool& black_lower_left) {
  const auto seen = FindChessboardCorners(grey, chess.cols, chess.rows);
  if (!seen) return std::nullopt;
  black_lower_left = seen->black_lower_left;
  CornerMap map(board);
  for (int row = 0; row < chess.rows; ++row) {
    for (int col = 0; col < chess.cols; ++col) map.At(col, row) = seen->corners[map.Index(col, row)];
  }
  return map;
}

// The tags of a grid: those that are found by themselves, then, from each to its neighbours, those that are
// where the grid has them.
class GridTracer {
 public:
  GridTracer(const cv::Mat& grey, const Board& board)
      : grey_(grey), board_(board), grid_(std::get<AprilGrid>(board)), map_(board) {}

  std::optional<CornerMap> Trace() {
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

  // The corner near a guess. None: there is none.
  std::optional<Vector2d> Find(CornerGuess guess, double within_px) const {
    const auto near = SearchCorner(grey_, guess, within_px);
    if (!near) return std::nullopt;
    guess.pixel = *near;
    const auto fit = FitCorner(grey_, guess);
    return fit ? fit->pixel : *near;
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
      const auto found = guess ? Find(*guess, std::clamp(0.12 * side, 2.0, 8.0)) : std::nullopt;
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
      const auto found = guess ? Find(*guess, std::clamp(0.1 * side, 2.0, 6.0)) : std::nullopt;
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

cv::Mat Grey(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

}  // namespace

std::vector<BoardCorner> FindBoard(const cv::Mat& image, const Board& board) {
  const cv::Mat grey = Grey(image);
  const Chessboard* chess = std::get_if<Chessboard>(&board);
  bool black_lower_left = true;
  const auto map =
      chess ? FindChessboard(grey, board, *chess, black_lower_left) : GridTracer(grey, board).Trace();
  if (!map) return {};
  return FitAll(grey, board, *map, black_lower_left);
}

std::vector<BoardCorner> RefitBoard(const cv::Mat& image, const Board& board,
                                    std::span<const BoardCorner> corners, const CameraModel& camera,
                                    const Pose& X_CT) {
  const cv::Mat grey = Grey(image);
  const std::vector<Vector2d> places = Corners(board);
  const int cols = CornerGrid(board).x();
  std::vector<BoardCorner> refitted;
  for (const BoardCorner& corner : corners) {
    const int col = corner.index % cols, row = corner.index / cols;
    const Vector2d& place = places[static_cast<std::size_t>(corner.index)];
    const auto at = [&](const Vector2d& p) {
      return Project(camera, X_CT * Eigen::Vector3d(p.x(), p.y(), 0));
    };
    const auto line = [&](int axis) -> std::optional<CornerMap::Line> {
      const double step_m = 0.1 * SurroundingsOf(board, col, row).clear_m[axis];
      const auto before = at(place - step_m * Vector2d::Unit(axis)), here = at(place);
      const auto after = at(place + step_m * Vector2d::Unit(axis));
      if (!before || !here || !after) return std::nullopt;
      return CornerMap::Line{(*after - *before) / (2 * step_m),
                             (*after - 2 * *here + *before) / (step_m * step_m), true};
    };
    const auto x = line(0), y = line(1);
    if (!x || !y) continue;
    const auto guess = GuessOf(board, col, row, corner.pixel, *x, *y, kMinClear_px, corner.black_lower_left);
    const auto fit = guess ? FitFree(grey, *guess) : std::nullopt;
    if (fit) {
      refitted.push_back({corner.index, fit->pixel, fit->covariance, corner.black_lower_left, fit->blur_px});
    }
  }
  return refitted;
}

}  // namespace kestrel::vision
