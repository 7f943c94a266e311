// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"

namespace kestrel::vision {

// A tag on a pad, upright: its top is at +x of T, its right at +y.
struct Tag {
  std::string family = "tag36h11";
  int id = 0;
  double side_m = 0.5;
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();  // its centre in T
};

void Fields(FieldVisitor& v, Tag& tag);

// Its corners in T, m, clockwise as seen from above from its top left: those that are detected.
std::array<Eigen::Vector2d, 4> CornersOf(const Tag& tag);

// What no pad can have: a tag that is not in its family, reaches beyond the picture or hides another. key: of the
// list.
void CheckTags(const std::vector<Tag>& tags, const Eigen::Vector2d& size_m, const Place& where,
               const std::string& key, Mistakes& mistakes);

// A pad of white with these tags, in order of their size the smallest uppermost: CV_8UC1, its sides powers of two
// up to 4096, and so that a cell of the smallest has some 8 px if there is room.
cv::Mat DrawTags(const std::vector<Tag>& tags, const Eigen::Vector2d& size_m);

}  // namespace kestrel::vision
