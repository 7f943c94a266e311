// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/board/chessboard_finder.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace kestrel::vision {
namespace {

using Corners2d = std::vector<Eigen::Vector2d>;

constexpr double kMaxBend = 0.4;          // between two neighbouring sides on a line, over the longer one
constexpr double kMinAlternating = 0.95;  // of the pairs of neighbouring squares
constexpr double kMinContrast_grey = 5;   // between such a pair, in the mean
constexpr std::size_t kMostToEnlarge = 2'000'000, kLeastToShrink = 1'000'000;  // pixels of the image

// Squares of a grid of corners, each by the light in its middle: how much brighter those at even places are.
struct Alternation {
  double even_brighter = 0;  // grey levels, in the mean over pairs of neighbours
  double share = 0;          // of the pairs that differ in that direction
};

double LightOfSquare(const cv::Mat& grey, const Eigen::Vector2d& at, double half_px) {
  const int half = std::max(0, static_cast<int>(half_px));
  const cv::Rect square(static_cast<int>(std::lround(at.x())) - half,
                        static_cast<int>(std::lround(at.y())) - half, 2 * half + 1, 2 * half + 1);
  const cv::Rect inside = square & cv::Rect(0, 0, grey.cols, grey.rows);
  return inside.empty() ? 0 : cv::mean(grey(inside))[0];
}

Alternation AlternationOf(const cv::Mat& grey, const Corners2d& corners, int cols, int rows) {
  const auto at = [&](int c, int r) { return corners[static_cast<std::size_t>(r * cols + c)]; };
  cv::Mat light(rows - 1, cols - 1, CV_64FC1);
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < cols; ++c) {
      const Eigen::Vector2d middle = (at(c, r) + at(c + 1, r) + at(c, r + 1) + at(c + 1, r + 1)) / 4;
      const double side = std::min((at(c + 1, r) - at(c, r)).norm(), (at(c, r + 1) - at(c, r)).norm());
      light.at<double>(r, c) = LightOfSquare(grey, middle, side / 6);
    }
  }
  int pairs = 0, brighter = 0;
  double sum = 0;
  const auto add = [&](int c, int r, int next_c, int next_r) {
    const double step =
        (light.at<double>(r, c) - light.at<double>(next_r, next_c)) * ((c + r) % 2 == 0 ? 1 : -1);
    ++pairs, sum += step, brighter += step > 0;
  };
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < cols; ++c) {
      if (c + 2 < cols) add(c, r, c + 1, r);
      if (r + 2 < rows) add(c, r, c, r + 1);
    }
  }
  if (pairs == 0) return {};
  const double share = static_cast<double>(sum > 0 ? brighter : pairs - brighter) / pairs;
  return {sum / pairs, share};
}

// Twice the area of a square of the grid, with its sign.
double Winding(const Corners2d& corners, int cols, int c, int r) {
  const auto at = [&](int col, int row) { return corners[static_cast<std::size_t>(row * cols + col)]; };
  const Eigen::Vector2d a = at(c + 1, r + 1) - at(c, r), b = at(c, r + 1) - at(c + 1, r);
  return a.x() * b.y() - a.y() * b.x();
}

bool LinesAreSmooth(const Corners2d& corners, int cols, int rows) {
  const auto smooth = [&](std::size_t i, std::size_t step) {
    const Eigen::Vector2d a = corners[i + step] - corners[i], b = corners[i + 2 * step] - corners[i + step];
    return (b - a).norm() <= kMaxBend * std::max(a.norm(), b.norm());
  };
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      const std::size_t i = static_cast<std::size_t>(r * cols + c);
      if (c + 2 < cols && !smooth(i, 1)) return false;
      if (r + 2 < rows && !smooth(i, static_cast<std::size_t>(cols))) return false;
    }
  }
  return true;
}

// The corners as one of the detectors finds them; empty: it does not.
using Detector = bool (*)(const cv::Mat&, cv::Size, std::vector<cv::Point2f>&);
bool BySectors(const cv::Mat& grey, cv::Size size, std::vector<cv::Point2f>& points) {
  return cv::findChessboardCornersSB(grey, size, points, cv::CALIB_CB_ACCURACY);
}
bool BySectorsNormalised(const cv::Mat& grey, cv::Size size, std::vector<cv::Point2f>& points) {
  return cv::findChessboardCornersSB(grey, size, points,
                                     cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY);
}
bool BySquares(const cv::Mat& grey, cv::Size size, std::vector<cv::Point2f>& points) {
  return cv::findChessboardCorners(grey, size, points,
                                   cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE);
}
bool BySquaresPlain(const cv::Mat& grey, cv::Size size, std::vector<cv::Point2f>& points) {
  return cv::findChessboardCorners(grey, size, points,
                                   cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_FILTER_QUADS);
}

// In the board's order: not mirrored, and of the two ways that are left the one with a black square at the
// lower left, if there is one.
SeenChessboard InOrder(const cv::Mat& grey, Corners2d corners, int cols, int rows) {
  // Rows of the image count downwards, those of the board upwards.
  if (Winding(corners, cols, 0, 0) > 0) {
    for (int r = 0; r < rows / 2; ++r) {
      for (int c = 0; c < cols; ++c) {
        std::swap(corners[static_cast<std::size_t>(r * cols + c)],
                  corners[static_cast<std::size_t>((rows - 1 - r) * cols + c)]);
      }
    }
  }
  // The square at the lower left corner of the board touches that between the first four corners.
  const auto black = [&] { return AlternationOf(grey, corners, cols, rows).even_brighter < 0; };
  if (!black()) {
    std::reverse(corners.begin(), corners.end());
    if (!black()) return {std::move(corners), false};
  }
  return {std::move(corners), true};
}

}  // namespace

bool IsChessboard(const cv::Mat& grey, const Corners2d& corners, int cols, int rows) {
  if (corners.size() != static_cast<std::size_t>(cols * rows)) return false;
  const double first = Winding(corners, cols, 0, 0);
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < cols; ++c) {
      if (!(Winding(corners, cols, c, r) * first > 0)) return false;
    }
  }
  if (!LinesAreSmooth(corners, cols, rows)) return false;
  const Alternation squares = AlternationOf(grey, corners, cols, rows);
  return squares.share >= kMinAlternating && std::abs(squares.even_brighter) >= kMinContrast_grey;
}

std::optional<SeenChessboard> FindChessboardCorners(const cv::Mat& grey, int cols, int rows) {
  const auto look = [&](double scale, Detector detect) -> std::optional<SeenChessboard> {
    cv::Mat scaled = grey;
    if (scale != 1) cv::resize(grey, scaled, {}, scale, scale, scale > 1 ? cv::INTER_CUBIC : cv::INTER_AREA);
    std::vector<cv::Point2f> points;
    if (!detect(scaled, {cols, rows}, points)) return std::nullopt;
    Corners2d corners;
    for (const cv::Point2f& p : points)
      corners.emplace_back((p.x + 0.5) / scale - 0.5, (p.y + 0.5) / scale - 0.5);
    if (!IsChessboard(grey, corners, cols, rows)) return std::nullopt;
    return InOrder(grey, std::move(corners), cols, rows);
  };
  std::vector<double> scales = {1};
  if (grey.total() >= kLeastToShrink) scales.push_back(0.5);
  if (grey.total() <= kMostToEnlarge) scales.push_back(2);
  for (const double scale : scales) {
    for (const Detector detect : {BySectors, BySectorsNormalised, BySquares, BySquaresPlain}) {
      // The search for squares takes seconds in a large image of another board, and gains nothing there.
      if (scale > 1 && (detect == BySquares || detect == BySquaresPlain)) continue;
      if (auto seen = look(scale, detect)) return seen;
    }
  }
  return std::nullopt;
}

}  // namespace kestrel::vision
