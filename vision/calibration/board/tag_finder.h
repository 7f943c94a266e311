// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace kestrel::vision {

// A tag of the family 36h11 with a border of two cells. Its corners, as it stands upright: lower left, lower
// right, upper right, upper left; good to a pixel or two.
struct SeenTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
};

// Where the picture of a tag is in an image: as its corners have it in perspective, and bent as its sides
// are, which through a wide lens bow by as much as a tenth of their length.
class TagPatch {
 public:
  // None: the corners are not of a quadrangle.
  static std::optional<TagPatch> Of(const cv::Mat& grey, const std::array<Eigen::Vector2d, 4>& corners);
  // The pixel of a place, in sides of the tag, right and up from its lower left corner; also outside it.
  Eigen::Vector2d At(double x, double y) const;

 private:
  Eigen::Matrix3d H_;
  std::array<Eigen::Vector2d, 4> bows_;  // of the lower, right, upper and left side at their middle, px
};

// The tags below an id that stand alone enough to be told by their outline: dark quadrangles with a code that
// differs from a tag's in at most three cells. OpenCV's and AprilTag's own detectors want a white frame,
// which the grid of Kalibr does not have: its squares touch the corners of its tags. grey: CV_8UC1.
std::vector<SeenTag> FindTags(const cv::Mat& grey, int ids);

// How many of the 100 cells of a tag with these corners are not as its picture has them.
int WrongCells(const cv::Mat& grey, const SeenTag& tag);

}  // namespace kestrel::vision
