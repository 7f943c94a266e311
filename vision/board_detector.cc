// SPDX-License-Identifier: Apache-2.0
#include "vision/board_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "vision/corner_fit.h"
#include "vision/homography.h"
#include "vision/tag_finder.h"

namespace kestrel {
namespace {

using Eigen::Vector2d;

constexpr double kLeastClear_px = 3.2;  // around a corner, free of anything else
constexpr double kLeastRadius_px = 2.5, kMostRadius_px = 7;
constexpr int kMostWrongCells = 8;  // of the 100 of a tag that is where it was expected

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
  // derivatives by the board's coordinate, px/m and px/m^2, from the nearest three corners on it; with two,
  // the first alone.
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
    const auto& [x1, u1] = others[0];
    if (others.size() == 1) return Line{u1 / x1};
    const auto& [x2, u2] = others[1];
    const Vector2d half_second = (u2 / x2 - u1 / x1) / (x2 - x1);
    return Line{u1 / x1 - half_second * x1, 2 * half_second, true};
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
                                   const CornerMap::Line& x, const CornerMap::Line& y) {
  const Surroundings around = SurroundingsOf(board, col, row);
  const Vector2d a = x.tangent * around.clear_m.x(), b = y.tangent * around.clear_m.y();
  const double clear = std::abs(Cross(a, b)) / std::max({a.norm(), b.norm(), 1e-12});
  if (!(clear >= kLeastClear_px)) return std::nullopt;
  return CornerGuess{pixel,
                     x.tangent,
                     y.tangent,
                     Bend(x, y.tangent),
                     Bend(y, x.tangent),
                     around.black_between,
                     std::clamp(clear - 1, kLeastRadius_px, kMostRadius_px)};
}

std::optional<CornerGuess> GuessAt(const Board& board, const CornerMap& map, int col, int row) {
  const auto x = map.LineAt(col, row, 0), y = map.LineAt(col, row, 1);
  if (!x || !y) return std::nullopt;
  return GuessOf(board, col, row, *map.At(col, row), *x, *y);
}

// Fits every corner of the map. Twice, since the curvature of the edges is known only once their corners
// are; a corner where it is never known is left out, as is one that cannot be fitted.
std::vector<BoardCorner> FitAll(const cv::Mat& grey, const Board& board, CornerMap map) {
  std::vector<BoardCorner> corners;
  for (int pass = 0; pass < 3; ++pass) {
    corners.clear();
    CornerMap fitted = map;
    for (int row = 0; row < map.rows(); ++row) {
      for (int col = 0; col < map.cols(); ++col) {
        fitted.At(col, row).reset();
        auto guess = GuessAt(board, map, col, row);
        if (!guess) continue;
        if (pass == 0) guess->bend_x = guess->bend_y = 0;
        auto fit = FitCorner(grey, *guess);
        // What stands around the corner spreads by its own blur.
        const double free_px = std::max(guess->radius_px + 1 - 2 * (fit ? fit->blur_px : 1), kLeastRadius_px);
        if (fit && free_px < guess->radius_px) {
          guess->pixel = fit->pixel;
          guess->radius_px = free_px;
          fit = FitCorner(grey, *guess);
        }
        if (!fit) continue;
        fitted.At(col, row) = fit->pixel;
        const bool bends_known = map.LineAt(col, row, 0)->bend_known && map.LineAt(col, row, 1)->bend_known;
        if (bends_known)
          corners.push_back({static_cast<int>(map.Index(col, row)), fit->pixel, fit->covariance});
      }
    }
    map = fitted;
  }
  return corners;
}

// The corners of a whole chessboard to a fraction of a pixel. In the order of Corners, the square at the
// lower left black.
std::optional<CornerMap> FindChessboard(const cv::Mat& grey, const Board& board, const Chessboard& chess) {
  std::vector<cv::Point2f> points;
  const int flags = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY;
  if (!cv::findChessboardCornersSB(grey, {chess.cols, chess.rows}, points, flags)) return std::nullopt;
  CornerMap map(board);
  const auto place = [&](bool rows_down, bool cols_left) {
    for (int row = 0; row < chess.rows; ++row) {
      for (int col = 0; col < chess.cols; ++col) {
        const int r = rows_down ? chess.rows - 1 - row : row, c = cols_left ? chess.cols - 1 - col : col;
        const cv::Point2f& p = points[static_cast<std::size_t>(r * chess.cols + c)];
        map.At(col, row) = Vector2d(p.x, p.y);
      }
    }
  };
  // Of the four ways to count, those that are not mirrored; of these, one with the right colours.
  for (const auto& [rows_down, cols_left] :
       {std::pair{true, false}, {false, true}, {false, false}, {true, true}}) {
    place(rows_down, cols_left);
    const auto guess = GuessAt(board, map, chess.cols / 2, chess.rows / 2);
    if (!guess || Cross(guess->along_x, guess->along_y) > 0) continue;  // rows of the image count downwards
    if (SearchCorner(grey, *guess, 1)) return map;
  }
  return std::nullopt;
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
  // Corner k of a tag in the grid of corners.
  static std::pair<int, int> Corner(int col, int row, int k) {
    return {2 * col + (k == 1 || k == 2 ? 1 : 0), 2 * row + (k > 1 ? 1 : 0)};
  }

  // Finds the exact corners of a tag near the rough ones; with all four, it is on the map.
  bool Place(const SeenTag& tag) {
    const int col = tag.id % grid_.cols, row = tag.id / grid_.cols;
    SeenTag exact = tag;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector2d& corner = tag.corners[k];
      const Vector2d x = (k == 0 || k == 3) ? tag.corners[k ^ 1] - corner : corner - tag.corners[k ^ 1];
      const Vector2d y = k < 2 ? tag.corners[3 - k] - corner : corner - tag.corners[3 - k];
      const auto [c, r] = Corner(col, row, static_cast<int>(k));
      auto guess = GuessOf(board_, c, r, corner, {x / grid_.tag_m}, {y / grid_.tag_m});
      if (!guess) return false;
      const double side = std::min(x.norm(), y.norm());
      const auto near = SearchCorner(grey_, *guess, std::clamp(0.12 * side, 2.0, 8.0));
      if (!near) return false;
      guess->pixel = *near;
      const auto fit = FitCorner(grey_, *guess);
      exact.corners[k] = fit ? fit->pixel : *near;
    }
    if (WrongCells(grey_, exact) > kMostWrongCells) return false;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = Corner(col, row, static_cast<int>(k));
      map_.At(c, r) = exact.corners[k];
    }
    return true;
  }

  // From a tag to the next one: across the gap to the near corners, then along both lines to the far ones.
  bool Step(int col, int row, int to_col, int to_row) {
    std::array<PointPair, 4> pairs;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = Corner(col, row, static_cast<int>(k));
      pairs[k] = {map_.Place(c, r), *map_.At(c, r)};
    }
    const auto H = FitHomography(pairs);
    if (!H) return false;
    SeenTag next;
    const int next_col = col + to_col, next_row = row + to_row;
    next.id = next_row * grid_.cols + next_col;
    const int axis = to_col != 0 ? 0 : 1;
    for (int pass = 0; pass < 2; ++pass) {  // near, far
      for (std::size_t k = 0; k < 4; ++k) {
        const auto [c, r] = Corner(next_col, next_row, static_cast<int>(k));
        const bool high = axis == 0 ? c % 2 == 1 : r % 2 == 1;
        const bool far = high == (to_col + to_row > 0);
        if (far != (pass == 1)) continue;
        if (!far) {
          next.corners[k] = Transfer(*H, map_.Place(c, r));
          if (const auto near = NearCorner(c, r, next.corners[k], *H)) next.corners[k] = *near;
          continue;
        }
        // The last three corners on the line, of which the nearest was just found.
        const int toward = to_col + to_row;
        const auto on_line = [&](int back) {
          return axis == 0 ? std::pair{c - back * toward, r} : std::pair{c, r - back * toward};
        };
        std::array<double, 3> x;
        std::array<Vector2d, 3> u;
        for (int back = 1; back <= 3; ++back) {
          const auto [bc, br] = on_line(back);
          const std::size_t i = static_cast<std::size_t>(back - 1);
          x[i] = map_.Place(bc, br)[axis];
          if (back > 1) u[i] = *map_.At(bc, br);
        }
        u[0] = next.corners[axis == 0 ? k ^ 1 : 3 - k];
        const double at = map_.Place(c, r)[axis];
        next.corners[k] = Vector2d::Zero();
        for (std::size_t i = 0; i < 3; ++i) {  // Lagrange's parabola
          double weight = 1;
          for (std::size_t j = 0; j < 3; ++j) {
            if (j != i) weight *= (at - x[j]) / (x[i] - x[j]);
          }
          next.corners[k] += weight * u[i];
        }
      }
    }
    return Place(next);
  }

  std::optional<Vector2d> NearCorner(int c, int r, const Vector2d& expected, const Eigen::Matrix3d& H) const {
    const double step = 0.1 * grid_.tag_m;
    const Vector2d x = (Transfer(H, map_.Place(c, r) + Vector2d(step, 0)) - expected) / step;
    const Vector2d y = (Transfer(H, map_.Place(c, r) + Vector2d(0, step)) - expected) / step;
    auto guess = GuessOf(board_, c, r, expected, {x}, {y});
    if (!guess) return std::nullopt;
    const auto near =
        SearchCorner(grey_, *guess, std::clamp(0.1 * std::min(x.norm(), y.norm()) * grid_.tag_m, 2.0, 6.0));
    if (!near) return std::nullopt;
    guess->pixel = *near;
    const auto fit = FitCorner(grey_, *guess);
    return fit ? fit->pixel : *near;
  }

  const cv::Mat& grey_;
  const Board& board_;
  const AprilGrid& grid_;
  CornerMap map_;
};

}  // namespace

std::vector<BoardCorner> FindBoard(const cv::Mat& image, const Board& board) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const Chessboard* chess = std::get_if<Chessboard>(&board);
  const auto map = chess ? FindChessboard(grey, board, *chess) : GridTracer(grey, board).Trace();
  if (!map) return {};
  return FitAll(grey, board, *map);
}

}  // namespace kestrel
