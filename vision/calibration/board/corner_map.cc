// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/corner_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/overloaded.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kMinRadius_px = 2.5, kMaxRadius_px = 7;
constexpr Eigen::Index kMaxDegree = 4;  // of the polynomial along a line of corners

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// The curvature of an edge, 1/px, towards the side where the other axis lies.
double Bend(const CornerMap::Line& line, const Vector2d& other) {
  const double length = line.tangent.norm();
  return Cross(line.tangent, line.second) / (length * length * length) *
         (Cross(line.tangent, other) > 0 ? 1 : -1);
}

}  // namespace

std::optional<CornerMap::Line> CornerMap::LineAt(int col, int row, int axis) const {
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

Surroundings SurroundingsOf(const Board& board, int col, int row) {
  const bool even = (row + col) % 2 == 0;
  return std::visit(Overloaded{[&](const Chessboard& c) {
                                 return Surroundings{even, {c.col_m, c.row_m}};
                               },
                               [&](const AprilGrid& grid) {
                                 // The tag's border, or the gap.
                                 const double clear = std::min(0.2, grid.spacing) * grid.tag_m;
                                 return Surroundings{even, {clear, clear}};
                               },
                               [&](const CharucoBoard& c) {
                                 // As far as the corner of the marker, across the corner of its square.
                                 const double clear = (c.square_m - c.marker_m) / 2 * std::numbers::sqrt2;
                                 return Surroundings{even == BlackLowerLeft(c), {clear, clear}};
                               },
                               [&](const CircleGrid& c) {
                                 return Surroundings{even, {c.spacing_m, c.spacing_m}};
                               }},
                    board);
}

std::optional<CornerGuess> GuessOf(const Board& board, int col, int row, const Vector2d& pixel,
                                   const CornerMap::Line& x, const CornerMap::Line& y, double least_clear_px,
                                   bool black_lower_left) {
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

std::pair<int, int> TagCorner(int tag_col, int tag_row, std::size_t k) {
  return {2 * tag_col + (k == 1 || k == 2 ? 1 : 0), 2 * tag_row + (k > 1 ? 1 : 0)};
}

CornerMap::Line LineIn(const TagPatch& patch, double side_m, double x, double y, int axis) {
  constexpr double kStep = 0.1;
  const Vector2d step = kStep * Vector2d::Unit(axis);
  const Vector2d before = patch.At(x - step.x(), y - step.y()), at = patch.At(x, y);
  const Vector2d after = patch.At(x + step.x(), y + step.y());
  const double step_m = kStep * side_m;
  return {(after - before) / (2 * step_m), (after - 2 * at + before) / (step_m * step_m), true};
}

std::optional<Vector2d> FindNear(const cv::Mat& grey, CornerGuess guess, double within_px) {
  const auto near = SearchCorner(grey, guess, within_px);
  if (!near) return std::nullopt;
  guess.pixel = *near;
  const auto fit = FitCorner(grey, guess);
  return fit ? fit->pixel : *near;
}

}  // namespace kestrel::vision
