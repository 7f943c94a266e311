// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/vision/calibration/board_photographer.h"
#include "vision/calibration/calibrate.h"

// Photographs of a board, from finding it to the camera.
namespace kestrel::vision {

struct BoardSet {
  std::vector<Pose> poses;
  std::vector<cv::Mat> images;
  std::vector<BoardView> views;
};

inline BoardSet PhotographSet(const CameraModel& camera, const Board& board, int count, std::uint64_t seed) {
  const BoardPicture picture = DrawBoard(board, 1024);
  std::mt19937_64 random(seed);
  BoardSet set;
  for (int i = 0; i < count; ++i) {
    set.poses.push_back(ScatteredPose(camera, board, random));
    set.images.push_back(PhotographBoard(camera, picture, set.poses.back(),
                                         seed + static_cast<std::uint64_t>(i), {.fine = 3}));
    set.views.push_back({std::to_string(i), FindBoard(set.images.back(), board)});
  }
  return set;
}

inline Calibration CalibrateSet(const Board& board, const BoardSet& set, const CameraModel& like) {
  return Calibrate(board, Refit(board, set.images, set.views, Calibrate(board, set.views, like)), like);
}

// Root mean square of the distances of corners from where the camera sees them, px.
inline double CornerError(const CameraModel& camera, const Board& board, const BoardSet& set,
                          const std::vector<BoardView>& views) {
  const std::vector<Eigen::Vector2d> places = Corners(board);
  double square = 0;
  int count = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const BoardCorner& corner : views[i].corners) {
      const Eigen::Vector2d& p = places[static_cast<std::size_t>(corner.index)];
      const auto uv = Project(camera, set.poses[i] * Eigen::Vector3d(p.x(), p.y(), 0));
      square += uv ? (*uv - corner.pixel).squaredNorm() : 1e6, ++count;
    }
  }
  return std::sqrt(square / std::max(count, 1));
}

}  // namespace kestrel::vision
