// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/calibration_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vision/calibration/calibration_start.h"

namespace kestrel::vision {
namespace {

constexpr double kSamePose = 0.02;       // of the image's diagonal: views nearer than this are one
constexpr double kMinReach = 0.5;        // of half the image's smaller side: the outermost corner
constexpr double kMaxLeftOut = 1.0 / 3;  // of the views that show enough of the board
constexpr double kAcceptedOfDiagonal = 1e-3;
constexpr double kSharp_px = 0.7;  // blur of an edge that spreads over two pixels
// Of the focal length. The double sphere has a valley of cameras that fit alike, of which its deviations,
// straight lines, see only the floor nearby.
constexpr double kMaxSigmaFocal = 0.05, kMaxSigmaFocalOfSpheres = 0.02;

// Of views that show the same, the first; their numbers.
std::vector<std::size_t> DifferentViews(std::span<const BoardView> views,
                                        const std::vector<std::size_t>& usable, double diagonal_px) {
  std::vector<std::size_t> different;
  for (const std::size_t i : usable) {
    const bool known = std::any_of(different.begin(), different.end(), [&](std::size_t j) {
      double sum = 0;
      int common = 0;
      for (const BoardCorner& a : views[i].corners) {
        for (const BoardCorner& b : views[j].corners) {
          if (a.index == b.index) sum += (a.pixel - b.pixel).norm(), ++common;
        }
      }
      return common > 0 && sum / common < kSamePose * diagonal_px;
    });
    if (!known) different.push_back(i);
  }
  return different;
}

std::string SeenIn(std::span<const BoardView> views) {
  std::string text;
  for (const BoardView& view : views)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", view.name, view.corners.size());
  return text;
}

}  // namespace

void CheckViews(const Board& board, std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                const CameraModel& like) {
  const auto any = std::any_of(views.begin(), views.end(), [](const auto& v) { return !v.corners.empty(); });
  if (!any)
    throw InputError({},
                     fmt::format("no {} was found in any of the {} images", Describe(board), views.size()));
  if (usable.size() < kMinViews) {
    throw InputError(
        {}, fmt::format("{} of {} images show at least {} corners of the {}; a calibration needs {}. "
                        "Corners seen: {}",
                        usable.size(), views.size(), kMinCorners, Describe(board), kMinViews, SeenIn(views)));
  }
  const double diagonal = std::hypot(WidthPx(like), HeightPx(like));
  const std::size_t different = DifferentViews(views, usable, diagonal).size();
  if (different < kMinViews) {
    throw InputError(
        {},
        fmt::format("the {} images that show the board show it in only {} different pose{}: a calibration "
                    "needs {}, tilted "
                    "and spread over the image",
                    usable.size(), different, different == 1 ? "" : "s", kMinViews));
  }
  const double half = std::min(WidthPx(like), HeightPx(like)) / 2.0;
  double reach = 0;
  for (const std::size_t i : usable) {
    for (const BoardCorner& corner : views[i].corners)
      reach = std::max(reach, (corner.pixel - MiddleOf(like)).norm());
  }
  if (reach < kMinReach * half) {
    throw InputError(
        {},
        fmt::format("the board is seen only within {:.0f} px of the middle of the image of {} x {}: show it "
                    "nearer to the "
                    "edges too, where the distortion is",
                    reach, WidthPx(like), HeightPx(like)));
  }
}

const char* RemedyFor(const CameraModel& camera) {
  if (std::holds_alternative<BrownConrady>(camera)) return "show more of the field, with more tilt";
  if (std::holds_alternative<DoubleSphere>(camera))
    return "take the model pinhole (to some 120 deg of view) or unified, or show more of the field, with "
           "more tilt";
  return "take the model pinhole (to some 120 deg of view), or show more of the field, with more tilt";
}

void CheckLeftOut(std::span<const BoardView> views, const std::vector<std::size_t>& usable,
                  const std::vector<std::string>& left_out, const CameraModel& like) {
  std::string names;
  double count = 0;
  for (std::size_t i = 0; i < usable.size(); ++i) {
    if (left_out[i].empty()) continue;
    names += fmt::format("{}{}", count == 0 ? "" : ", ", views[usable[i]].name);
    ++count;
  }
  if (count <= kMaxLeftOut * static_cast<double>(usable.size())) return;
  throw InputError(
      {},
      fmt::format(
          "{:g} of {} images do not fit the {} camera of the others: {}. They may be of another camera, or "
          "of "
          "one whose zoom or focus changed; or the board's numbers (counts, side, spacing) are wrong, or the "
          "lens is one for another model",
          count, usable.size(), NameOf(like), names));
}

double AcceptedResidual(std::span<const BoardView> views, const CameraModel& like) {
  std::vector<double> blurs;
  for (const BoardView& view : views) {
    for (const BoardCorner& corner : view.corners) blurs.push_back(corner.blur_px);
  }
  double blur_px = 0;
  if (!blurs.empty()) {
    const auto middle = blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() / 2);
    std::nth_element(blurs.begin(), middle, blurs.end());
    blur_px = *middle;
  }
  return kAcceptedOfDiagonal * std::hypot(WidthPx(like), HeightPx(like)) * std::max(1.0, blur_px / kSharp_px);
}

void CheckResidual(const Calibration& c, double accepted_px) {
  if (c.rms_px <= accepted_px) return;
  std::vector<const CalibratedView*> used;
  for (const CalibratedView& view : c.views) {
    if (view.left_out.empty()) used.push_back(&view);
  }
  std::stable_sort(used.begin(), used.end(), [](auto* a, auto* b) { return a->rms_px > b->rms_px; });
  std::string worst;
  for (std::size_t i = 0; i < std::min<std::size_t>(used.size(), 3); ++i)
    worst += fmt::format("{}{} {:.2f}", i == 0 ? "" : ", ", used[i]->name, used[i]->rms_px);
  throw PoorFit({},
                fmt::format("the {} model does not fit: {:.2f} px rms are left between what it says and "
                            "what {} images show, where "
                            "{:.2g} px are accepted; worst: {}. The board's numbers may be wrong (counts, "
                            "side, spacing), the images "
                            "of several cameras, or of one whose zoom or focus changed, the board not "
                            "flat, or the lens one for "
                            "another model",
                            NameOf(c.camera), c.rms_px, used.size(), accepted_px, worst));
}

void CheckFocalLength(const Calibration& c) {
  const double most =
      std::holds_alternative<DoubleSphere>(c.camera) ? kMaxSigmaFocalOfSpheres : kMaxSigmaFocal;
  if (c.sigma.head<2>().maxCoeff() <= most * Parameters(c.camera)[0]) return;
  const std::vector<std::string> names = ParameterNames(c.camera);
  std::string open;
  for (std::size_t i = 0; i < c.free.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(c.free[i])];
    if (name == "fx" || name == "xi" || name == "alpha")
      open += fmt::format("{}{} {:.4g} +- {:.2g}", open.empty() ? "" : ", ", name,
                          Parameters(c.camera)[c.free[i]], c.sigma[static_cast<Eigen::Index>(i)]);
  }
  throw InputError({}, fmt::format("the images do not determine the {} model: {}; {}", NameOf(c.camera), open,
                                   RemedyFor(c.camera)));
}

}  // namespace kestrel::vision
