// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_reference.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

constexpr int kSmallestSide_px = 24;
constexpr int kMaxCorners = 6000;
constexpr double kCornerQuality = 0.02;
constexpr double kCornerDistance_px = 5;
constexpr int kRim_px = 4;
constexpr double kShapes_px_per_m = 300;  // scale at which it is searched for rectangles and circles
constexpr int kAlike_px = 64;             // side at which a picture is compared with itself turned
constexpr double kAlike = 0.95;           // correlation from which on it looks the same

PadReference::Level MakeLevel(const cv::Mat& image, double length_m, double width_m) {
  PadReference::Level level;
  level.image = image;
  const double sx = image.cols / width_m, sy = image.rows / length_m;
  level.px_per_m = std::sqrt(sx * sy);
  // The picture's edges are half a pixel outside the centres of its outermost pixels.
  level.pixel_from_T << 0, sx, sx * width_m / 2 - 0.5, -sy, 0, sy * length_m / 2 - 0.5, 0, 0, 1;
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(0));
  mask(cv::Rect(kRim_px, kRim_px, image.cols - 2 * kRim_px, image.rows - 2 * kRim_px)).setTo(255);
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(image, found, kMaxCorners, kCornerQuality, kCornerDistance_px, mask, 5);
  const Eigen::Matrix3d T_from_pixel = level.pixel_from_T.inverse();
  for (const cv::Point2f& c : found) {
    level.corners.push_back((T_from_pixel * Eigen::Vector3d(c.x, c.y, 1)).head<2>());
  }
  return level;
}

int TurnsOf(const cv::Mat& grey, double length_m, double width_m) {
  cv::Mat small;
  cv::resize(grey, small, {kAlike_px, kAlike_px}, 0, 0, cv::INTER_AREA);
  const auto alike = [&](int how) {
    cv::Mat turned, correlation;
    cv::rotate(small, turned, how);
    cv::matchTemplate(turned, small, correlation, cv::TM_CCOEFF_NORMED);
    return correlation.at<float>(0, 0) > kAlike;
  };
  if (std::abs(length_m - width_m) < 0.05 * length_m && alike(cv::ROTATE_90_CLOCKWISE)) return 4;
  return alike(cv::ROTATE_180) ? 2 : 1;
}

}  // namespace

std::vector<Eigen::Vector2d> PadReference::Outline() const {
  const double x = length_m / 2, y = width_m / 2;
  return {{x, -y}, {x, y}, {-x, y}, {-x, -y}};
}

const PadReference::Level& PadReference::LevelFor(double px_per_m) const {
  const Level* best = &levels.front();
  for (std::size_t i = 0; i < levels.size(); i += kLevelsOfOctave)
    if (levels[i].px_per_m >= 0.75 * px_per_m) best = &levels[i];
  return *best;
}

const PadReference::Level& PadReference::NearestLevel(double px_per_m) const {
  const auto octaves = [&](const Level& level) { return std::abs(std::log2(level.px_per_m / px_per_m)); };
  return *std::min_element(levels.begin(), levels.end(),
                           [&](const Level& a, const Level& b) { return octaves(a) < octaves(b); });
}

Eigen::Matrix3d NearestTurn(const Eigen::Matrix3d& H_w, int turns,
                            const std::optional<Eigen::Matrix3d>& H_expected) {
  // Where a step along the pad's x leads in the image.
  const auto up = [](const Eigen::Matrix3d& H) {
    constexpr double kStep_m = 0.1;
    return Eigen::Vector2d((H * Eigen::Vector3d(kStep_m, 0, 1)).hnormalized() - H.col(2).hnormalized())
        .normalized();
  };
  const Eigen::Vector2d wanted = H_expected ? up(*H_expected) : Eigen::Vector2d(0, -1);
  Eigen::Matrix3d best = H_w;
  for (int k = 1; k < turns; ++k) {
    const Eigen::Matrix3d turned =
        H_w * Eigen::AngleAxisd(k * 2 * M_PI / turns, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    if (up(turned).dot(wanted) > up(best).dot(wanted)) best = turned;
  }
  return best;
}

PadReference MakePadReference(const cv::Mat& picture, double length_m, double width_m) {
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  PadReference reference{length_m, width_m, {}, {}, TurnsOf(grey, length_m, width_m), {}};
  // By half octaves: drawn from one that is farther from the image's resolution, the pad is blurred, or shows what the
  // image does not.
  for (double scale = 1;; scale *= std::exp2(-1.0 / PadReference::kLevelsOfOctave)) {
    const cv::Size size(static_cast<int>(std::lround(grey.cols * scale)),
                        static_cast<int>(std::lround(grey.rows * scale)));
    if (std::min(size.width, size.height) < kSmallestSide_px && scale < 1) break;
    cv::Mat image = grey;  // which nobody changes
    if (size != grey.size()) cv::resize(grey, image, size, 0, 0, cv::INTER_AREA);
    reference.levels.push_back(MakeLevel(image, length_m, width_m));
  }
  const PadReference::Level& fine = reference.LevelFor(kShapes_px_per_m);
  reference.shapes = ShapesOf(fine.image, fine.pixel_from_T, reference.Outline());
  return reference;
}

}  // namespace kestrel::vision
