// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/patch/match_corners.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr int kPictureSide_px = 200;
const cv::Size kImage(320, 240);
constexpr int kAround = 90;

// A smooth pattern that is known between its pixels too, by px of the picture.
double Pattern(const Vector2d& p) {
  return 128 + 45 * std::sin(0.31 * p.x() + 0.12 * p.y()) * std::cos(0.27 * p.y()) +
         30 * std::sin(0.17 * p.x() - 0.23 * p.y());
}

cv::Mat Picture() {
  cv::Mat picture(kPictureSide_px, kPictureSide_px, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      picture.at<uchar>(y, x) = cv::saturate_cast<uchar>(Pattern({x, y}));
  return picture;
}

// Aslant, turned by 20 degrees.
Matrix3d ImageFromPicture() {
  Matrix3d H;
  H << 0.86, -0.31, 110, 0.33, 0.9, 12, 2e-4, -1e-4, 1;
  return H;
}

// The picture by H, and what lies around it: the mean over each pixel, by the pattern itself.
cv::Mat Seen(const Matrix3d& H, const Exposure& exposure, int around = kAround) {
  constexpr int kFine = 4;
  const Matrix3d inverse = H.inverse();
  cv::Mat image(kImage, CV_8UC1);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      double sum = 0;
      for (int k = 0; k < kFine * kFine; ++k) {
        const double u = x + (k % kFine + 0.5) / kFine - 0.5, v = y + (k / kFine + 0.5) / kFine - 0.5;
        const Vector2d p = (inverse * Eigen::Vector3d(u, v, 1)).hnormalized();
        const bool on_it = p.minCoeff() >= -0.5 && p.maxCoeff() < kPictureSide_px - 0.5;
        sum += on_it ? exposure.gain * Pattern(p) + exposure.offset : around;
      }
      image.at<uchar>(y, x) = cv::saturate_cast<uchar>(sum / (kFine * kFine));
    }
  return image;
}

// By H, of those that lie in the image.
std::vector<Vector2d> Corners(const Matrix3d& H, int from_px, int step_px) {
  std::vector<Vector2d> corners;
  for (int y = from_px; y < kPictureSide_px - from_px; y += step_px)
    for (int x = from_px; x < kPictureSide_px - from_px; x += step_px) {
      const Vector2d uv = (H * Eigen::Vector3d(x, y, 1)).hnormalized();
      if (uv.minCoeff() > 3 && uv.x() < kImage.width - 4 && uv.y() < kImage.height - 4) corners.push_back(uv);
    }
  return corners;
}

struct Found {
  int found = 0;
  double worst_px = 0;
  GreySums greys;
};
Found Compare(const std::vector<CornerMatch>& matches, const std::vector<Vector2d>& drawn,
              const Vector2d& shift) {
  Found all;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!matches[i].found) continue;
    ++all.found;
    all.worst_px = std::max(all.worst_px, (matches[i].at - drawn[i] - shift).norm());
    all.greys += matches[i].greys;
  }
  return all;
}

TEST(MatchCorners, FindsAShiftToHundredthsOfAPixelAslantAndInAnotherExposure) {
  const Vector2d shift(1.7, -2.2);
  const Exposure exposure{0.7, 20};
  const Matrix3d drawn_by = ImageFromPicture();
  Matrix3d moved = Matrix3d::Identity();
  moved.topRightCorner<2, 1>() = shift;
  const cv::Mat image = Seen(moved * drawn_by, exposure);
  const std::vector<Vector2d> drawn = Corners(drawn_by, 20, 16);
  ASSERT_GT(drawn.size(), 80u);
  const auto all =
      Compare(MatchCorners(Picture(), drawn_by.inverse(), image, drawn, exposure, kAround), drawn, shift);
  EXPECT_EQ(all.found, static_cast<int>(drawn.size()));
  EXPECT_LT(all.worst_px, 0.05);
  EXPECT_GT(all.greys.Correlation(), 0.998);
}

TEST(MatchCorners, TheRimOfThePictureIsAnEdgeToGoBy) {
  const Vector2d shift(-1.1, 0.8);
  const Matrix3d drawn_by = ImageFromPicture();
  Matrix3d moved = Matrix3d::Identity();
  moved.topRightCorner<2, 1>() = shift;
  const std::vector<Vector2d> drawn = Corners(drawn_by, 4, 24);
  for (const int around : {0, 90, 255}) {
    const cv::Mat image = Seen(moved * drawn_by, {}, around);
    const auto all =
        Compare(MatchCorners(Picture(), drawn_by.inverse(), image, drawn, {}, around), drawn, shift);
    EXPECT_EQ(all.found, static_cast<int>(drawn.size()));
    EXPECT_LT(all.worst_px, 0.5) << around;
  }
}

// So that variables that nobody has set are no numbers.
[[gnu::noinline]] void LeaveRubbishOnTheStack() {
  std::array<volatile unsigned char, 1 << 16> rubbish;
  for (volatile unsigned char& byte : rubbish) byte = 0xff;
}

TEST(MatchCorners, NearTheRimOfTheImageOnlyWhatIsInItCounts) {
  Matrix3d up = Matrix3d::Identity();
  up(1, 2) = -70;  // so that a part of it is out of view
  const Matrix3d drawn_by = up * ImageFromPicture();
  const cv::Mat image = Seen(drawn_by, {});
  std::vector<Vector2d> drawn;
  for (const Vector2d& uv : Corners(drawn_by, 10, 4))
    if (uv.y() < 6) drawn.push_back(uv);
  ASSERT_GT(drawn.size(), 5u);
  LeaveRubbishOnTheStack();
  const auto all = Compare(MatchCorners(Picture(), drawn_by.inverse(), image, drawn, {}, kAround), drawn,
                           Vector2d::Zero());
  EXPECT_EQ(all.found, static_cast<int>(drawn.size()));
  EXPECT_LT(all.worst_px, 0.05);
}

TEST(MatchCorners, TheExposureFollowsFromTheGreysOfTheMatches) {
  const Exposure exposure{0.8, 30};
  const Matrix3d drawn_by = ImageFromPicture();
  const cv::Mat image = Seen(drawn_by, exposure);
  const std::vector<Vector2d> drawn = Corners(drawn_by, 20, 16);
  const GreySums g =
      Compare(MatchCorners(Picture(), drawn_by.inverse(), image, drawn, {}, kAround), drawn, {0, 0}).greys;
  const double slope = (g.xy - g.x * g.y / g.n) / (g.xx - g.x * g.x / g.n);
  EXPECT_NEAR(slope, exposure.gain, 0.02);
  EXPECT_NEAR((g.y - slope * g.x) / g.n, exposure.offset, 3);
}

TEST(MatchCorners, AnEvenPictureAndAnEvenImageHoldNothing) {
  const Matrix3d drawn_by = ImageFromPicture();
  const std::vector<Vector2d> drawn = Corners(drawn_by, 20, 40);
  const cv::Mat even_picture(kPictureSide_px, kPictureSide_px, CV_8UC1, cv::Scalar(77));
  for (const CornerMatch& match :
       MatchCorners(even_picture, drawn_by.inverse(), Seen(drawn_by, {}), drawn, {}, kAround))
    EXPECT_FALSE(match.found);
  const cv::Mat even_image(kImage, CV_8UC1, cv::Scalar(77));
  for (const CornerMatch& match :
       MatchCorners(Picture(), drawn_by.inverse(), even_image, drawn, {}, kAround)) {
    EXPECT_TRUE(!match.found || match.greys.Correlation() < 0.1);
  }
}

TEST(MatchCorners, AnotherPictureIsNotAlike) {
  const Matrix3d drawn_by = ImageFromPicture();
  const std::vector<Vector2d> drawn = Corners(drawn_by, 20, 16);
  cv::Mat noise(kImage, CV_8UC1);
  cv::RNG(5).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {9, 9}, 2);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  int alike = 0;
  for (const CornerMatch& match : MatchCorners(Picture(), drawn_by.inverse(), noise, drawn, {}, kAround))
    alike += match.found && match.greys.Correlation() > 0.7;
  EXPECT_LT(alike, 0.1 * static_cast<double>(drawn.size()));
}

}  // namespace
}  // namespace kestrel::vision
