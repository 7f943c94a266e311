// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/outline/outlines.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

namespace kestrel::vision {
namespace {

constexpr double kMinArea_px2 = 250;
constexpr std::size_t kMinPoints = 40, kMaxCandidates = 40;
constexpr double kRound =
    0.03;  // root mean square of a contour's distance from its ellipse, as a share of its size

using Contour = Contours::value_type;

// Of a picture of two values, the largest.
void AddLarge(const cv::Mat& binary, Contours& all) {
  Contours contours;
  cv::findContours(binary, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  std::erase_if(contours, [](const Contour& c) {
    return c.size() < kMinPoints || std::abs(cv::contourArea(c)) < kMinArea_px2;
  });
  std::sort(contours.begin(), contours.end(),
            [](const Contour& a, const Contour& b) { return a.size() > b.size(); });
  if (contours.size() > kMaxCandidates) contours.resize(kMaxCandidates);
  std::move(contours.begin(), contours.end(), std::back_inserter(all));
}

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

// Whether most of each side lies near the straight line between its corners, as a rectangle's does though part of it be
// hidden. It is told in a hundredth of the time that the sides' fits take, and rules out what grows.
bool MostlyStraight(const Contour& contour, const std::array<int, 4>& at) {
  constexpr double kNear_px = 12;
  const int n = static_cast<int>(contour.size());
  for (int k = 0; k < 4; ++k) {
    const int from = at[k], count = (at[(k + 1) % 4] - from + n) % n;
    const Eigen::Vector2d a(contour[from].x, contour[from].y);
    const Eigen::Vector2d along = Eigen::Vector2d(contour[at[(k + 1) % 4]].x, contour[at[(k + 1) % 4]].y) - a;
    const double most = kNear_px * along.norm();
    int near = 0;
    for (int i = 0; i < count; ++i) {
      const cv::Point& p = contour[(from + i) % n];
      near += std::abs(along.x() * (p.y - a.y()) - along.y() * (p.x - a.x())) <= most;
    }
    if (2 * near < count) return false;
  }
  return true;
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
  if (!MostlyStraight(contour, at)) return std::nullopt;
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

// Least squares of rows that are to give 1.
template <int kCount>
Eigen::Vector<double, kCount> FitOnes(const std::vector<Eigen::Vector<double, kCount>>& rows) {
  Eigen::Matrix<double, kCount, kCount> squares = Eigen::Matrix<double, kCount, kCount>::Zero();
  Eigen::Vector<double, kCount> sum = Eigen::Vector<double, kCount>::Zero();
  for (const auto& row : rows) squares += row * row.transpose(), sum += row;
  return squares.ldlt().solve(sum);
}

// Some of its points tell what is plainly none in a fraction of the time of cv::fitEllipse: by a conic through them, and
// about its middle another, whose value is the square of the distance from the middle as a share of the ellipse's.
bool MayBeEllipse(const Contour& contour) {
  constexpr std::size_t kPoints = 100;
  constexpr double kMargin = 4;  // of fewer points, and by another fit
  const cv::Point2d about = (cv::Point2d(contour.front()) + cv::Point2d(contour[contour.size() / 2])) / 2;
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::Vector<double, 5>> conic_rows;
  for (std::size_t i = 0; i < std::min(kPoints, contour.size()); ++i) {
    const cv::Point2d p =
        cv::Point2d(contour[i * contour.size() / std::min(kPoints, contour.size())]) - about;
    const double x = p.x / 100, y = p.y / 100;
    points.emplace_back(x, y);
    conic_rows.emplace_back(x * x, y * y, x * y, x, y);
  }
  const auto conic = FitOnes<5>(conic_rows);
  Eigen::Matrix2d form;
  form << 2 * conic[0], conic[2], conic[2], 2 * conic[1];
  const Eigen::Vector2d middle = -form.inverse() * conic.tail<2>();
  std::vector<Eigen::Vector<double, 3>> rows;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d q = p - middle;
    rows.emplace_back(q.x() * q.x(), q.y() * q.y(), q.x() * q.y());
  }
  const Eigen::Vector3d centred = FitOnes<3>(rows);
  double squares = 0;
  for (const auto& row : rows) squares += std::pow(std::sqrt(std::max(0.0, row.dot(centred))) - 1, 2);
  return squares < std::pow(kMargin * kRound, 2) * static_cast<double>(rows.size());
}

std::optional<Ellipse> EllipseOf(const Contour& contour) {
  if (!MayBeEllipse(contour)) return std::nullopt;
  const cv::RotatedRect box = cv::fitEllipse(contour);
  if (!(std::min(box.size.width, box.size.height) > 4)) return std::nullopt;
  const double turn = box.angle * CV_PI / 180;
  Eigen::Matrix2d R;
  R << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  const Ellipse ellipse{{box.center.x, box.center.y},
                        R * Eigen::Vector2d(box.size.width / 2.0, box.size.height / 2.0).asDiagonal()};
  const Eigen::Matrix2d to_circle = ellipse.axes.inverse();
  double squares = 0;
  for (const cv::Point& p : contour)
    squares += std::pow((to_circle * (Eigen::Vector2d(p.x, p.y) - ellipse.middle)).norm() - 1, 2);
  if (!(squares < kRound * kRound * static_cast<double>(contour.size()))) return std::nullopt;
  return ellipse;
}

}  // namespace

// By a global threshold, then by local ones against uneven light.
Contours LargeContours(const cv::Mat& grey) {
  Contours all;
  cv::Mat smooth, binary;
  cv::GaussianBlur(grey, smooth, {3, 3}, 0);
  for (const int block : {0, 31, 101}) {
    if (block == 0) {
      cv::threshold(smooth, binary, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
    } else {
      cv::adaptiveThreshold(smooth, binary, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY, block, 0);
    }
    AddLarge(binary, all);
  }
  return all;
}

// By global thresholds that leave so small a share of the image below them.
Contours DarkContours(const cv::Mat& grey) {
  Contours all;
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {5, 5}, 0);
  std::array<int, 256> counts{};
  for (int y = 0; y < smooth.rows; ++y)
    for (int x = 0; x < smooth.cols; ++x) ++counts[smooth.at<uchar>(y, x)];
  int level = 0, below = 0, last = -1;
  for (const double share : {0.01, 0.02, 0.04, 0.08, 0.16}) {
    while (level < 255 && below < share * static_cast<double>(smooth.total())) below += counts[level++];
    if (std::exchange(last, level) != level) AddLarge(smooth < level, all);
  }
  return all;
}

std::vector<Quad> QuadsOf(const Contours& contours) {
  std::vector<Quad> quads;
  for (const Contour& contour : contours)
    if (const auto quad = QuadOf(contour)) quads.push_back(*quad);
  return quads;
}

std::vector<Ellipse> EllipsesOf(const Contours& contours) {
  std::vector<Ellipse> ellipses;
  for (const Contour& contour : contours) {
    if (const auto ellipse = EllipseOf(contour)) ellipses.push_back(*ellipse);
  }
  return ellipses;
}

}  // namespace kestrel::vision
