// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/landmark/outline/pad_shapes.h"
#include "vision/tag/tag.h"

namespace kestrel::vision {

// The reference appearance of a rectangular helipad, at scales half an octave apart, with its corners by Shi
// and Tomasi. T is the pad's frame: origin at its centre, x along its length towards the top of the picture,
// y to the right of the picture, z down into the ground.
struct PadReference {
  struct Level {
    cv::Mat image;                 // CV_8UC1
    Eigen::Matrix3d pixel_from_T;  // affine: (x, y, 1) of T, m, to a pixel of this level
    std::vector<Eigen::Vector2d>
        corners;  // in T, m; the strongest first, none so near the rim that the ground shows
    double px_per_m = 0;
  };
  double length_m = 0, width_m = 0;
  static constexpr std::size_t kLevelsOfOctave = 2;
  std::vector<Level> levels;  // the finest first, which is the picture itself
  std::vector<Tag> tags;      // of which its picture is made, if it is: then it is found by them
  int turns = 1;  // in how many directions it looks alike: 2 after half a turn, 4 after each quarter
  PadShapes shapes;

  // The four corners in T, m, clockwise as seen from above, from the picture's top left.
  std::vector<Eigen::Vector2d> Outline() const;
  // Of whole octaves: the coarsest that is at least three quarters as fine as px_per_m, the finest where none is.
  const Level& LevelFor(double px_per_m) const;
  // Of all: what an image of that resolution would show, neither blurred nor finer.
  const Level& NearestLevel(double px_per_m) const;
};

// The direction, of those in which the pad looks alike, that is nearest to what is expected; where nothing is,
// that with the top of the picture nearest to the top of the image, as for one who flies ahead.
Eigen::Matrix3d NearestTurn(const Eigen::Matrix3d& H_w, int turns,
                            const std::optional<Eigen::Matrix3d>& H_expected);

// picture: the pad seen from above, CV_8UC1 or CV_8UC3, filled to its rim. One that is grey is kept, not copied.
PadReference MakePadReference(const cv::Mat& picture, double length_m, double width_m);

}  // namespace kestrel::vision
