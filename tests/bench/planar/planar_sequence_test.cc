// SPDX-License-Identifier: Apache-2.0
#include "bench/planar/planar_sequence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "bench/planar/planar_pictures.h"

namespace kestrel::bench {
namespace {

using Eigen::Vector2d;

constexpr double kPicture_px_per_m = 1024 / kPlanarWidth_m;

// Discs on a white sheet, and where their middles are in T.
constexpr double kAlong_m[] = {0.36, 0, -0.36}, kAcross_m[] = {-0.5, -0.2, 0.2, 0.5};
cv::Mat Discs() {
  cv::Mat sheet(kPictureSize, CV_8UC1, cv::Scalar(250));
  for (const double x : kAlong_m)
    for (const double y : kAcross_m) {
      // Pixel (0, 0) is half a pixel inside the sheet's corner.
      const cv::Point2d at(kPicture_px_per_m * (kPlanarWidth_m / 2 + y) - 0.5,
                           kPicture_px_per_m * (kPlanarLength_m / 2 - x) - 0.5);
      constexpr int kShift = 8;
      cv::circle(sheet, {cvRound(at.x * (1 << kShift)), cvRound(at.y * (1 << kShift))}, 14 << kShift, 20,
                 cv::FILLED, cv::LINE_AA, kShift);
    }
  return sheet;
}

// By OpenCV, from the pose: independent of what draws.
Vector2d Projected(const Pose& X_CT, const Vector2d& p_T) {
  cv::Matx33d R;
  const Eigen::Matrix3d from = X_CT.R.toRotationMatrix();
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = from(i / 3, i % 3);
  cv::Vec3d turn;
  cv::Rodrigues(R, turn);
  const vision::Pinhole& c = kPlanarCamera;
  const cv::Matx33d K(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  std::vector<cv::Point2d> uv;
  cv::projectPoints(std::vector<cv::Point3d>{{p_T.x(), p_T.y(), 0}}, turn,
                    cv::Vec3d(X_CT.p.x(), X_CT.p.y(), X_CT.p.z()), K, {}, uv);
  return {uv[0].x, uv[0].y};
}

// The middle of what is dark about a place, weighted by how dark it is.
Vector2d DarkMiddle(const cv::Mat& image, const Vector2d& about, int half) {
  Vector2d sum = Vector2d::Zero();
  double weight = 0;
  for (int v = cvRound(about.y()) - half; v <= cvRound(about.y()) + half; ++v)
    for (int u = cvRound(about.x()) - half; u <= cvRound(about.x()) + half; ++u) {
      const double dark = std::max(0.0, 215.0 - image.at<uchar>(v, u));
      sum += dark * Vector2d(u, v), weight += dark;
    }
  return sum / weight;
}

TEST(PlanarSequence, DrawsThePictureWhereTheTruthSaysItIs) {
  const cv::Mat sheet = Discs();
  for (const PlanarFactor factor : kPlanarFactors) {
    const PlanarSequence sequence(sheet, factor, 3);
    int checked = 0;
    for (int frame = 0; frame < kPlanarFrames; frame += 37) {
      const PlanarFrame drawn = sequence.Draw(frame);
      if (drawn.visible < 0.99) continue;
      const Pose X_CT = sequence.X_CT(frame / kPlanarRate_hz);
      for (const double x : kAlong_m)
        for (const double y : kAcross_m) {
          const Vector2d at = Projected(X_CT, {x, y});
          const Eigen::Vector3d by_truth = drawn.H_w * Eigen::Vector3d(x, y, 1);
          EXPECT_LT((by_truth.hnormalized() - at).norm(), 1e-6) << NameOf(factor);
          const double radius = 14 / kPicture_px_per_m * kPlanarCamera.fx / X_CT.p.z();
          const bool blurred = factor == PlanarFactor::kMotionBlur || factor == PlanarFactor::kUnconstrained;
          if (blurred && frame > 0) continue;  // the middle of the exposure is not that of what is smeared
          // Nor is the middle of a disc's image, seen aslant, the image of its middle.
          if (X_CT.R.toRotationMatrix()(2, 2) < std::cos(0.5)) continue;
          EXPECT_LT((DarkMiddle(drawn.image, at, cvRound(radius) + 3) - at).norm(), 0.12)
              << NameOf(factor) << ", frame " << frame;
          ++checked;
        }
    }
    EXPECT_GE(checked, 12) << NameOf(factor);
  }
}

TEST(PlanarSequence, TellsHowMuchOfThePictureIsToBeSeen) {
  const cv::Mat white(kPictureSize, CV_8UC1, cv::Scalar(255));
  for (const PlanarFactor factor : {PlanarFactor::kOcclusion, PlanarFactor::kOutOfView}) {
    const PlanarSequence sequence(white, factor, 2);
    double least = 1, most = 0;
    for (int frame = 0; frame < kPlanarFrames; frame += 11) {
      const PlanarFrame drawn = sequence.Draw(frame);
      int seen = 0, all = 0;
      constexpr int kGrid = 40;
      for (int i = 0; i < kGrid; ++i)
        for (int k = 0; k < kGrid; ++k, ++all) {
          const Vector2d p_T(((i + 0.5) / kGrid - 0.5) * kPlanarLength_m,
                             ((k + 0.5) / kGrid - 0.5) * kPlanarWidth_m);
          const Vector2d at = Projected(sequence.X_CT(frame / kPlanarRate_hz), p_T);
          const cv::Point px(cvRound(at.x()), cvRound(at.y()));
          seen += cv::Rect({0, 0}, drawn.image.size()).contains(px) && drawn.image.at<uchar>(px) > 235;
        }
      const double share = static_cast<double>(seen) / all;
      EXPECT_NEAR(drawn.visible, share, 0.03) << NameOf(factor) << ", frame " << frame;
      least = std::min(least, share), most = std::max(most, share);
    }
    EXPECT_GT(most, 0.99) << NameOf(factor);
    EXPECT_LT(least, factor == PlanarFactor::kOutOfView ? 0.001 : 0.42) << NameOf(factor);
  }
}

TEST(PlanarSequence, IsTheSameForTheSameSeedAlone) {
  const cv::Mat picture = PlanarPictures(5).front().grey;
  const auto image = [&](std::uint64_t seed) {
    return PlanarSequence(picture, PlanarFactor::kUnconstrained, seed).Draw(40).image;
  };
  EXPECT_EQ(cv::norm(image(1), image(1), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(image(1), image(2), cv::NORM_INF), 50);
}

}  // namespace
}  // namespace kestrel::bench
