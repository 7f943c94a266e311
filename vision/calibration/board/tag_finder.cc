// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/tag_finder.h"

#include <Eigen/QR>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "vision/calibration/board/board.h"
#include "vision/calibration/board/tag_36h11.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kCellCount = kTagCells * kTagCells;
constexpr double kMinTagContrast = 12;  // grey levels
constexpr int kMaxWrongBits = 3;        // two codes of the family differ in 11
constexpr int kMaxWrongBorder = 6;      // of 64 cells
constexpr double kMinSide_px = 12;

double LightAt(const cv::Mat& grey, const Vector2d& at) {
  const int u = static_cast<int>(std::floor(at.x())), v = static_cast<int>(std::floor(at.y()));
  if (!(u >= 0 && v >= 0 && u + 1 < grey.cols && v + 1 < grey.rows)) return std::nan("");
  const double du = at.x() - u, dv = at.y() - v;
  const std::uint8_t *top = grey.ptr(v) + u, *low = grey.ptr(v + 1) + u;
  return (1 - dv) * ((1 - du) * top[0] + du * top[1]) + dv * ((1 - du) * low[0] + du * low[1]);
}

// How far the middle of a tag's side is bowed from the straight line between its ends, px, by a parabola
// through where the light grows most from the black border to the gap outside. That the ends are not exact
// only shifts and turns the line, which the parabola allows for.
Vector2d Bow(const cv::Mat& grey, const Vector2d& from, const Vector2d& to, const Vector2d& inside) {
  const Vector2d along = to - from;
  Vector2d outwards(-along.y(), along.x());
  outwards.normalize();
  if (outwards.dot(inside - from) > 0) outwards = -outwards;
  const double reach = 0.14 * along.norm() + 1;
  constexpr int kPlaces = 9;
  Eigen::Matrix<double, kPlaces, 3> powers;
  Eigen::Matrix<double, kPlaces, 1> offsets;
  for (int i = 0; i < kPlaces; ++i) {
    const double t = (i + 1.0) / (kPlaces + 1);
    const Vector2d at = from + t * along;
    double steepest = 0, offset = 0;
    for (double d = -reach; d <= reach; d += 0.25) {
      const double rise = LightAt(grey, at + (d + 1.5) * outwards) - LightAt(grey, at + (d - 1.5) * outwards);
      if (rise > steepest) steepest = rise, offset = d;
    }
    powers.row(i) << 1, t, 4 * t * (1 - t);
    offsets[i] = offset;
  }
  return powers.colPivHouseholderQr().solve(offsets)[2] * outwards;
}

// White or not, of the cells row by row from the top left; none where they do not differ or lie outside.
std::optional<std::array<bool, kCellCount>> ReadCells(const cv::Mat& grey,
                                                      const std::array<Vector2d, 4>& corners) {
  const auto patch = TagPatch::Of(grey, corners);
  if (!patch) return std::nullopt;
  std::array<double, kCellCount> light;
  for (int i = 0; i < kTagCells * kTagCells; ++i) {
    double& cell = light[static_cast<std::size_t>(i)];
    cell = LightAt(grey, patch->At((i % kTagCells + 0.5) / kTagCells, 1 - (i / kTagCells + 0.5) / kTagCells));
    if (!std::isfinite(cell)) return std::nullopt;
  }
  std::array<double, kCellCount> sorted = light;
  std::sort(sorted.begin(), sorted.end());
  // Every tag has at least 75 black cells and 10 white ones.
  const double black = sorted[37], white = sorted[94];
  if (!(white - black > kMinTagContrast)) return std::nullopt;
  std::array<bool, kCellCount> cells;
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = light[i] > (black + white) / 2;
  return cells;
}

// Its code, if the border is black.
std::optional<std::uint64_t> ReadCode(const cv::Mat& grey, const std::array<Vector2d, 4>& corners) {
  const auto cells = ReadCells(grey, corners);
  if (!cells) return std::nullopt;
  int wrong = 0;
  std::uint64_t code = 0;
  for (int row = 0; row < kTagCells; ++row) {
    for (int col = 0; col < kTagCells; ++col) {
      const bool white = (*cells)[static_cast<std::size_t>(row * kTagCells + col)];
      const bool border =
          std::min(row, col) < kTagBorderCells || std::max(row, col) >= kTagCells - kTagBorderCells;
      if (border) {
        wrong += white;
      } else {
        code = code << 1 | (white ? 1 : 0);
      }
    }
  }
  if (wrong > kMaxWrongBorder) return std::nullopt;
  return code;
}

std::optional<SeenTag> Decode(const cv::Mat& grey, const std::array<Vector2d, 4>& corners, int ids) {
  std::array<Vector2d, 4> turned = corners;
  for (int turn = 0; turn < 4; ++turn) {
    if (const auto code = ReadCode(grey, turned)) {
      for (int id = 0; id < ids; ++id) {
        if (std::popcount(*code ^ TagCode(id)) <= kMaxWrongBits) return SeenTag{id, turned};
      }
    }
    std::rotate(turned.begin(), turned.begin() + 1, turned.end());
  }
  return std::nullopt;
}

// The corners of a dark patch that has four, counter-clockwise to the eye, moved outwards by what the patch
// was shrunk.
std::optional<std::array<Vector2d, 4>> Quadrangle(const std::vector<cv::Point>& outline, double shrunk_px) {
  std::vector<cv::Point> hull, rough;
  cv::convexHull(outline, hull);
  const double around = cv::arcLength(hull, true);
  if (around < 4 * kMinSide_px) return std::nullopt;
  for (const double share : {0.03, 0.05, 0.08}) {
    cv::approxPolyDP(hull, rough, share * around, true);
    if (rough.size() == 4) break;
  }
  if (rough.size() != 4) return std::nullopt;
  std::array<Vector2d, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = {rough[i].x, rough[i].y};
  double area = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d &a = corners[i], &b = corners[(i + 1) % 4];
    area += a.x() * b.y() - a.y() * b.x();
    if ((b - a).norm() < kMinSide_px / 2) return std::nullopt;
  }
  if (area > 0) std::reverse(corners.begin(), corners.end());  // rows of the image count downwards
  const std::array<Vector2d, 4> tight = corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d &before = tight[(i + 3) % 4], &after = tight[(i + 1) % 4];
    corners[i] += shrunk_px * ((tight[i] - before).normalized() + (tight[i] - after).normalized());
  }
  return corners;
}

}  // namespace

std::optional<TagPatch> TagPatch::Of(const cv::Mat& grey, const std::array<Vector2d, 4>& corners) {
  const std::array<PointPair, 4> pairs{PointPair{{0, 0}, corners[0]}, PointPair{{1, 0}, corners[1]},
                                       PointPair{{1, 1}, corners[2]}, PointPair{{0, 1}, corners[3]}};
  const auto H = FitHomography(pairs);
  if (!H) return std::nullopt;
  TagPatch patch;
  patch.H_ = *H;
  const Vector2d inside = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
  for (std::size_t i = 0; i < 4; ++i) patch.bows_[i] = Bow(grey, corners[i], corners[(i + 1) % 4], inside);
  return patch;
}

Vector2d TagPatch::At(double x, double y) const {
  return Transfer(H_, {x, y}) + 4 * x * (1 - x) * ((1 - y) * bows_[0] + y * bows_[2]) +
         4 * y * (1 - y) * (x * bows_[1] + (1 - x) * bows_[3]);
}

std::vector<SeenTag> FindTags(const cv::Mat& grey, int ids) {
  std::vector<SeenTag> tags;
  std::vector<bool> seen(static_cast<std::size_t>(ids));
  for (const int window : {15, 31, 61, 121}) {  // a tag of a third of it to all of it
    cv::Mat dark;
    cv::adaptiveThreshold(grey, dark, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, window, 4);
    for (const int shrunk : {1, 2}) {  // parts the tags from the squares at their corners
      cv::Mat apart;
      cv::erode(dark, apart, cv::getStructuringElement(cv::MORPH_RECT, {2 * shrunk + 1, 2 * shrunk + 1}));
      std::vector<std::vector<cv::Point>> outlines;
      cv::findContours(apart, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
      for (const auto& outline : outlines) {
        const auto corners = Quadrangle(outline, shrunk);
        if (!corners) continue;
        const auto tag = Decode(grey, *corners, ids);
        if (!tag || seen[static_cast<std::size_t>(tag->id)]) continue;
        seen[static_cast<std::size_t>(tag->id)] = true;
        tags.push_back(*tag);
      }
    }
  }
  return tags;
}

int WrongCells(const cv::Mat& grey, const SeenTag& tag) {
  const auto cells = ReadCells(grey, tag.corners);
  if (!cells) return kTagCells * kTagCells;
  const std::uint64_t code = TagCode(tag.id);
  int wrong = 0;
  for (int row = 0; row < kTagCells; ++row) {
    for (int col = 0; col < kTagCells; ++col) {
      const int i = row - kTagBorderCells, j = col - kTagBorderCells;
      const bool inside = i >= 0 && i < kTagCodeCells && j >= 0 && j < kTagCodeCells;
      const bool white =
          inside && (code >> (kTagCodeCells * kTagCodeCells - 1 - kTagCodeCells * i - j) & 1) != 0;
      wrong += white != (*cells)[static_cast<std::size_t>(row * kTagCells + col)];
    }
  }
  return wrong;
}

}  // namespace kestrel::vision
