// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/landmark/homography.h"
#include "vision/landmark/plane_pose.h"

namespace kestrel::vision {
namespace {

constexpr double kMinArea_px2 = 250;
constexpr double kAspectTolerance = 1.35;  // factor; far away the tilt makes the ratio uncertain
constexpr double kMinPlausibleCorrelation = 0.55;
constexpr double kCompare_px_per_m = 60;  // scale at which candidates are compared with the reference
constexpr double kRectangles_px_per_m =
    300;                               // scale at which the reference is searched for its own rectangles
constexpr double kMinRectangle = 0.3;  // share of the pad that such a rectangle covers
constexpr std::size_t kMaxCandidates = 40;

using Quad = std::array<Eigen::Vector2d, 4>;

// A straight line through the contour's points between two corners, away from the corners themselves.
Eigen::Vector3d LineBetween(const std::vector<cv::Point>& contour, int from, int to) {
  const int n = static_cast<int>(contour.size());
  const int count = (to - from + n) % n;
  const int skip = count / 8 + 1;
  std::vector<cv::Point2f> points;
  for (int k = skip; k <= count - skip; ++k) points.push_back(contour[(from + k) % n]);
  if (points.size() < 2) points = {contour[from], contour[to]};
  cv::Vec4f line;
  cv::fitLine(points, line, cv::DIST_HUBER, 0, 0.01, 0.01);
  const Eigen::Vector3d a(line[2], line[3], 1), b(line[2] + line[0], line[3] + line[1], 1);
  return a.cross(b);
}

// The contour as a quadrilateral with corners at the crossings of its fitted sides.
std::optional<Quad> QuadOf(const std::vector<cv::Point>& contour) {
  std::vector<cv::Point> corners;
  cv::approxPolyDP(contour, corners, 0.03 * cv::arcLength(contour, true), true);
  if (corners.size() != 4 || !cv::isContourConvex(corners)) return std::nullopt;
  std::array<int, 4> at;
  for (int k = 0; k < 4; ++k) {
    at[k] = static_cast<int>(std::find(contour.begin(), contour.end(), corners[k]) - contour.begin());
  }
  std::array<Eigen::Vector3d, 4> side;
  for (int k = 0; k < 4; ++k) side[k] = LineBetween(contour, at[k], at[(k + 1) % 4]);
  Quad quad;
  for (int k = 0; k < 4; ++k) {
    quad[k] = side[(k + 3) % 4].cross(side[k]).hnormalized();
    // Fitted crossings far from the polygon's corner: not a quadrilateral after all.
    if (!((quad[k] - Eigen::Vector2d(corners[k].x, corners[k].y)).norm() < 12)) return std::nullopt;
  }
  const double turn =
      (quad[1] - quad[0]).x() * (quad[2] - quad[1]).y() - (quad[1] - quad[0]).y() * (quad[2] - quad[1]).x();
  if (turn < 0) std::swap(quad[1], quad[3]);  // clockwise in the image, like PadReference::Outline
  return quad;
}

std::vector<Quad> Quads(const cv::Mat& grey) {
  std::vector<Quad> quads;
  cv::Mat smooth, binary;
  cv::GaussianBlur(grey, smooth, {3, 3}, 0);
  for (const int block : {0, 31, 101}) {  // a global threshold, then local ones against uneven light
    if (block == 0) {
      cv::threshold(smooth, binary, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
    } else {
      cv::adaptiveThreshold(smooth, binary, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY, block, 0);
    }
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(binary, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    std::erase_if(contours,
                  [](const auto& c) { return c.size() < 40 || std::abs(cv::contourArea(c)) < kMinArea_px2; });
    std::sort(contours.begin(), contours.end(),
              [](const auto& a, const auto& b) { return a.size() > b.size(); });
    if (contours.size() > kMaxCandidates) contours.resize(kMaxCandidates);
    for (const auto& contour : contours) {
      if (const auto quad = QuadOf(contour)) quads.push_back(*quad);
    }
  }
  return quads;
}

double AreaOf(const Quad& quad) {
  const Eigen::Vector2d a = quad[2] - quad[0], b = quad[3] - quad[1];
  return std::abs(a.x() * b.y() - a.y() * b.x()) / 2;
}

}  // namespace

PadDetector::PadDetector(const PadReference& reference, const Pinhole& camera)
    : camera_(camera), level_(reference.LevelFor(kCompare_px_per_m)) {
  const std::vector<Eigen::Vector2d> outline = reference.Outline();
  rectangles_.push_back({outline[0], outline[1], outline[2], outline[3]});
  const PadReference::Level& fine = reference.LevelFor(kRectangles_px_per_m);
  constexpr int kBorder_px = 20;
  cv::Mat bordered;
  cv::copyMakeBorder(fine.image, bordered, kBorder_px, kBorder_px, kBorder_px, kBorder_px,
                     cv::BORDER_CONSTANT, 128);
  const Eigen::Matrix3d T_from_pixel = fine.pixel_from_T.inverse();
  const double side = std::sqrt(AreaOf(rectangles_[0]));
  for (const Quad& quad : Quads(bordered)) {
    Quad quad_T;
    for (int k = 0; k < 4; ++k)
      quad_T[k] = Transfer(T_from_pixel, quad[k] - Eigen::Vector2d(kBorder_px, kBorder_px));
    if (AreaOf(quad_T) < kMinRectangle * side * side) continue;
    // First the corner nearest to the picture's top left, as in the outline.
    int first = 0;
    for (int k = 1; k < 4; ++k) {
      if ((quad_T[k] - outline[0]).norm() < (quad_T[first] - outline[0]).norm()) first = k;
    }
    std::rotate(quad_T.begin(), quad_T.begin() + first, quad_T.end());
    const bool known = std::any_of(rectangles_.begin(), rectangles_.end(), [&](const Quad& other) {
      return (other[0] - quad_T[0]).norm() + (other[2] - quad_T[2]).norm() < 0.02 * side;
    });
    if (!known) rectangles_.push_back(quad_T);
  }
}

std::optional<Eigen::Matrix3d> PadDetector::Detect(const cv::Mat& grey) const {
  const Quad square = {
      {{1, 0}, {1, 1}, {0, 1}, {0, 0}}};  // the corners of a unit rectangle, in the outline's order
  std::optional<Eigen::Matrix3d> best;
  double best_correlation = kMinPlausibleCorrelation;
  for (const Quad& quad : Quads(grey)) {
    for (const Quad& rectangle : rectangles_) {
      const double aspect = (rectangle[1] - rectangle[0]).norm() / (rectangle[3] - rectangle[0]).norm();
      for (int turn = 0; turn < 4; ++turn) {
        std::array<PointPair, 4> unit, metric;
        for (int k = 0; k < 4; ++k) {
          unit[k] = {square[k], quad[(k + turn) % 4]};
          metric[k] = {rectangle[k], quad[(k + turn) % 4]};
        }
        const auto H_unit = FitHomography(unit), H_w = FitHomography(metric);
        if (!H_unit || !H_w || !PoseFromHomography(*H_w, camera_)) continue;
        const double off = RectangleAspect(*H_unit, camera_) / aspect;
        if (!(off < kAspectTolerance && off > 1 / kAspectTolerance)) continue;
        cv::Mat map, view, correlation;
        cv::eigen2cv(Eigen::Matrix3d(*H_w * level_.pixel_from_T.inverse()), map);
        cv::warpPerspective(grey, view, map, level_.image.size(), cv::INTER_AREA | cv::WARP_INVERSE_MAP);
        cv::matchTemplate(view, level_.image, correlation, cv::TM_CCOEFF_NORMED);
        if (correlation.at<float>(0, 0) > best_correlation) {
          best_correlation = correlation.at<float>(0, 0);
          best = H_w;
        }
      }
    }
  }
  return best;
}

}  // namespace kestrel::vision
