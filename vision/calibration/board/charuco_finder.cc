// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/charuco_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "vision/tag/tag_detector.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector2d;

constexpr double kSameCorner_px = 1.5;  // of two markers that have it, the one's place off the other's

// A marker in the image: its corners from the lower left on, as it stands upright, as TagPatch has them.
struct SeenMarker {
  Vector2d low;  // its lower left corner in T, m
  TagPatch patch;
  double side_px = 0;  // the shortest
};

std::vector<SeenMarker> FindMarkers(const cv::Mat& grey, const CharucoBoard& board) {
  const std::vector<CharucoMarker> markers = Markers(board);
  std::vector<Tag> tags;
  for (const CharucoMarker& marker : markers)
    tags.push_back({.family = board.dictionary, .id = marker.id, .side_m = board.marker_m});
  std::vector<SeenMarker> seen;
  for (const DetectedTag& tag : TagDetector(tags).Detect(grey)) {
    // Detected clockwise from the upper left.
    const std::array<Vector2d, 4> corners = {tag.corners[3], tag.corners[2], tag.corners[1], tag.corners[0]};
    const auto patch = TagPatch::Of(grey, corners);
    if (!patch) continue;
    double side = (corners[3] - corners[0]).norm();
    for (std::size_t k = 0; k < 3; ++k) side = std::min(side, (corners[k + 1] - corners[k]).norm());
    seen.push_back({markers[tag.index].low, *patch, side});
  }
  return seen;
}

}  // namespace

std::optional<CornerMap> FindCharuco(const cv::Mat& grey, const Board& any) {
  const CharucoBoard& board = std::get<CharucoBoard>(any);
  CornerMap map(any);
  std::vector<bool> doubtful(static_cast<std::size_t>(map.cols() * map.rows()));
  for (const SeenMarker& marker : FindMarkers(grey, board)) {
    for (int k = 0; k < 4; ++k) {
      // The corners of the marker's square.
      const int col = static_cast<int>(std::lround(marker.low.x() / board.square_m - 0.5 +
                                                   board.marker_m / board.square_m / 2)) +
                      k % 2;
      const int row = static_cast<int>(std::lround(marker.low.y() / board.square_m - 0.5 +
                                                   board.marker_m / board.square_m / 2)) +
                      k / 2;
      if (col < 0 || row < 0 || col >= map.cols() || row >= map.rows()) continue;
      const Vector2d at = (map.Place(col, row) - marker.low) / board.marker_m;
      const auto guess = GuessOf(any, col, row, marker.patch.At(at.x(), at.y()),
                                 LineIn(marker.patch, board.marker_m, at.x(), at.y(), 0),
                                 LineIn(marker.patch, board.marker_m, at.x(), at.y(), 1), kMinToFind_px);
      const auto found =
          guess ? FindNear(grey, *guess, std::clamp(0.12 * marker.side_px, 2.0, 6.0)) : std::nullopt;
      if (!found) continue;
      auto& known = map.At(col, row);
      if (known && (*known - *found).norm() > kSameCorner_px) doubtful[map.Index(col, row)] = true;
      known = *found;
    }
  }
  bool any_corner = false;
  for (int row = 0; row < map.rows(); ++row) {
    for (int col = 0; col < map.cols(); ++col) {
      if (doubtful[map.Index(col, row)]) map.At(col, row).reset();
      any_corner = any_corner || map.At(col, row);
    }
  }
  if (!any_corner) return std::nullopt;
  return map;
}

}  // namespace kestrel::vision
