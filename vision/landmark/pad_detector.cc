// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_detector.h"

#include <array>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/landmark/even_light.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

namespace kestrel::vision {
namespace {

constexpr double kAspectTolerance = 1.35;  // factor; far away the tilt makes the ratio uncertain
constexpr double kMinPlausibleCorrelation = 0.55;
constexpr double kMinEvenlyLitCorrelation =
    0.5;                                  // see EvenlyLit: less of it is the frame's, which many things have
constexpr double kCompare_px_per_m = 60;  // scale at which candidates are compared with the reference
constexpr int kEvened_px = 19;  // over which light is evened there: 0.3 m, some of the pad's details
constexpr int kDirections = 24;

}  // namespace

PadDetector::PadDetector(const PadReference& reference, const Pinhole& camera)
    : camera_(camera),
      level_(reference.LevelFor(kCompare_px_per_m)),
      evenly_lit_(EvenlyLit(level_.image, kEvened_px)),
      shapes_(reference.shapes) {}

// A circle tells all but the direction, as long as the view is not very oblique from near.
void PadDetector::AddCircles(const Contours& contours, std::vector<Eigen::Matrix3d>& candidates) const {
  if (shapes_.circles.empty()) return;
  for (const Ellipse& ellipse : EllipsesOf(contours)) {
    for (const PadShapes::Circle& circle : shapes_.circles) {
      for (int turn = 0; turn < kDirections; ++turn) {
        const Eigen::Matrix2d A = ellipse.axes *
                                  Eigen::Rotation2Dd(2 * M_PI * turn / kDirections).toRotationMatrix() /
                                  circle.radius;
        Eigen::Matrix3d H_w = Eigen::Matrix3d::Identity();
        H_w.topLeftCorner<2, 2>() = A;
        H_w.topRightCorner<2, 1>() = ellipse.middle - A * circle.middle;
        candidates.push_back(H_w);
      }
    }
  }
}

void PadDetector::AddQuads(const std::vector<Quad>& quads, std::vector<Eigen::Matrix3d>& candidates) const {
  const Quad square = {
      {{1, 0}, {1, 1}, {0, 1}, {0, 0}}};  // the corners of a unit rectangle, in the outline's order
  for (const Quad& quad : quads) {
    for (const Quad& rectangle : shapes_.rectangles) {
      const double aspect = (rectangle[1] - rectangle[0]).norm() / (rectangle[3] - rectangle[0]).norm();
      for (int turn = 0; turn < 4; ++turn) {
        std::array<PointPair, 4> unit, metric;
        for (int k = 0; k < 4; ++k) {
          unit[k] = {square[k], quad[(k + turn) % 4]};
          metric[k] = {rectangle[k], quad[(k + turn) % 4]};
        }
        const auto H_unit = FitHomography(unit), H_w = FitHomography(metric);
        if (!H_unit || !H_w) continue;
        const double off = RectangleAspect(*H_unit, camera_) / aspect;
        if (off < kAspectTolerance && off > 1 / kAspectTolerance) candidates.push_back(*H_w);
      }
    }
  }
}

// What each candidate makes of the image is compared with the reference.
std::optional<Eigen::Matrix3d> PadDetector::Detect(const cv::Mat& grey) const {
  std::vector<Eigen::Matrix3d> candidates;
  const Contours contours = LargeContours(grey);
  AddQuads(QuadsOf(contours), candidates);
  AddCircles(contours, candidates);
  for (const bool evened : {false, true}) {
    if (evened) AddQuads(QuadsOf(DarkContours(grey)), candidates);
    double best = evened ? kMinEvenlyLitCorrelation : kMinPlausibleCorrelation;
    std::optional<Eigen::Matrix3d> found;
    for (const Eigen::Matrix3d& H_w : candidates) {
      if (!PoseFromHomography(H_w, camera_)) continue;
      cv::Mat map, view, correlation;
      cv::eigen2cv(Eigen::Matrix3d(H_w * level_.pixel_from_T.inverse()), map);
      cv::warpPerspective(grey, view, map, level_.image.size(), cv::INTER_AREA | cv::WARP_INVERSE_MAP);
      if (evened) view = EvenlyLit(view, kEvened_px);
      cv::matchTemplate(view, evened ? evenly_lit_ : level_.image, correlation, cv::TM_CCOEFF_NORMED);
      if (correlation.at<float>(0, 0) > best) best = correlation.at<float>(0, 0), found = H_w;
    }
    if (found) return found;
  }
  return std::nullopt;
}

}  // namespace kestrel::vision
