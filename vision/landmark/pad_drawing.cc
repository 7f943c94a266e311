// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_drawing.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/drawn_colours.h"

namespace kestrel::vision {
namespace {

std::optional<cv::Point2d> InFrame(const CameraModel& camera, const Eigen::Vector3d& p_CQ) {
  constexpr double kFarOff_px = 1e4;  // what OpenCV still draws
  const auto uv = Project(camera, p_CQ);
  if (!uv || !(uv->cwiseAbs().maxCoeff() < kFarOff_px)) return std::nullopt;
  return cv::Point2d(uv->x(), uv->y());
}

}  // namespace

void DrawPoints(cv::Mat& bgr, const CameraModel& camera, const Pinhole& view,
                const std::vector<Eigen::Vector2d>& points, int radius_px, const cv::Scalar& colour) {
  for (const Eigen::Vector2d& p : points) {
    const auto ray = view.Ray(p);
    const auto at = ray ? InFrame(camera, *ray) : std::nullopt;
    if (at) cv::circle(bgr, *at, radius_px, colour, 1, cv::LINE_AA);
  }
}

void DrawOutlineAndAxes(cv::Mat& bgr, const CameraModel& camera, const Pose& X_CT,
                        const std::vector<Eigen::Vector2d>& outline_T) {
  // A straight side is a curve in a wide image.
  constexpr int kPieces = 16;
  std::optional<cv::Point2d> last;
  for (std::size_t k = 0; k <= outline_T.size() * kPieces; ++k) {
    const Eigen::Vector2d &from = outline_T[k / kPieces % outline_T.size()],
                          &to = outline_T[(k / kPieces + 1) % outline_T.size()];
    const double share = static_cast<double>(k % kPieces) / kPieces;
    const Eigen::Vector2d p_T = (1 - share) * from + share * to;
    const auto at = InFrame(camera, X_CT * Eigen::Vector3d(p_T.x(), p_T.y(), 0));
    if (at && last) cv::line(bgr, *last, *at, kFixColour, 2, cv::LINE_AA);
    last = at;
  }
  // As long as a third of the longer side.
  double longest = 0;
  for (std::size_t k = 1; k < outline_T.size(); ++k)
    longest = std::max(longest, (outline_T[k] - outline_T[k - 1]).norm());
  const double length = 0.3 * longest;
  const auto origin = InFrame(camera, X_CT.p);
  const cv::Scalar colours[3] = {{60, 60, 255}, {60, 220, 60}, {255, 120, 60}};
  for (int axis = 0; axis < 3; ++axis) {
    // z is drawn upwards: down into the ground it would hide behind the pad
    const Eigen::Vector3d tip = (axis == 2 ? -length : length) * Eigen::Vector3d::Unit(axis);
    const auto end = InFrame(camera, X_CT * tip);
    if (origin && end) cv::arrowedLine(bgr, *origin, *end, colours[axis], 2, cv::LINE_AA, 0, 0.12);
  }
}

}  // namespace kestrel::vision
