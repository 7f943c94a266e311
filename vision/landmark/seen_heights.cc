// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/seen_heights.h"

#include <algorithm>
#include <cmath>

#include "vision/tag/tag_family.h"

namespace kestrel::vision {
namespace {

constexpr double kFindSide_px = 36, kCell_px = 3;
constexpr double kFollowRim_px = 3;  // within which no corner is followed
constexpr double kStep = 0.97;
constexpr double kAlignedShare = 0.06;  // of the picture that must be in the image

// The greatest height at which a length has so many pixels.
double HeightFor(const Pinhole& camera, double length_m, double px) {
  return std::min(camera.fx, camera.fy) * length_m / px;
}

// Half of what the image shows of the ground, along the image's height and width; T's x is upwards.
Eigen::Vector2d HalfView(const Pinhole& camera, double height_m) {
  return height_m * Eigen::Vector2d((camera.height_px / 2.0 - kFollowRim_px) / camera.fy,
                                    (camera.width_px / 2.0 - kFollowRim_px) / camera.fx);
}

SeenHeights OfTag(const Tag& tag, const Pinhole& camera) {
  const TagFamily family = TagFamilyOf(tag.family);
  const double cell = tag.side_m / family.border_cells;
  // The code may reach beyond the square; of one that does not, a cell around it must be seen.
  const double half =
      std::max((tag.side_m + 2 * cell) / 2, cell * (family.reversed ? family.total_cells : 0) / 2);
  const Eigen::Vector2d reach = tag.at_m.cwiseAbs().array() + half, view = HalfView(camera, 1);
  return {reach.cwiseQuotient(view).maxCoeff(), HeightFor(camera, cell, kCell_px)};
}

// Whether enough of the picture is in view of a camera at that height to be followed.
bool IsFollowed(const PadReference& pad, const Pinhole& camera, const PadTrackerOptions& options,
                double height_m) {
  const Eigen::Vector2d view = HalfView(camera, height_m);
  if (options.method == "icia") {
    const Eigen::Vector2d half(pad.length_m / 2, pad.width_m / 2);
    return view.cwiseMin(half).prod() >= kAlignedShare * half.prod();
  }
  const auto& corners = pad.LevelFor(camera.fx / height_m).corners;
  return std::count_if(corners.begin(), corners.end(), [&](const Eigen::Vector2d& corner) {
           return (corner.cwiseAbs().array() < view.array()).all();
         }) >= options.min_inliers;
}

// Down from where it is found and followed to where it is not followed any more.
SeenHeights OfPicture(const PadReference& pad, const Pinhole& camera, const PadTrackerOptions& options) {
  double max = HeightFor(camera, std::min(pad.length_m, pad.width_m), kFindSide_px);
  while (max > 0.05 && !IsFollowed(pad, camera, options, max)) max *= kStep;
  double min = max;
  for (double height = max; height > 0.05 && IsFollowed(pad, camera, options, height); height *= kStep)
    min = height;
  return {min, max};
}

}  // namespace

std::vector<SeenHeights> HeightsSeen(const PadReference& pad, const Pinhole& camera,
                                     const PadTrackerOptions& options) {
  std::vector<SeenHeights> all, joined;
  if (pad.tags.empty()) all.push_back(OfPicture(pad, camera, options));
  for (const Tag& tag : pad.tags) all.push_back(OfTag(tag, camera));
  std::erase_if(all, [](const SeenHeights& range) { return !(range.min_m < range.max_m); });
  std::sort(all.begin(), all.end(),
            [](const SeenHeights& a, const SeenHeights& b) { return a.min_m < b.min_m; });
  for (const SeenHeights& range : all) {
    if (!joined.empty() && range.min_m <= joined.back().max_m)
      joined.back().max_m = std::max(joined.back().max_m, range.max_m);
    else
      joined.push_back(range);
  }
  return joined;
}

}  // namespace kestrel::vision
