// SPDX-License-Identifier: Apache-2.0
// Photographs with known homographies: the samples of OpenCV's documentation (Debian's opencv-doc).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "vision/landmark/estimation/homography_solutions.h"
#include "vision/landmark/estimation/robust_homography.h"
#include "vision/landmark/features/features.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

const std::filesystem::path kSamples = "/usr/share/doc/opencv-doc/examples/data";

cv::Mat Grey(const char* name) { return cv::imread((kSamples / name).string(), cv::IMREAD_GRAYSCALE); }

std::vector<PointPair> Paired(const Features& a, const Features& b, const std::vector<Match>& matches) {
  std::vector<PointPair> pairs;
  for (const Match& match : matches) {
    const cv::Point2f p = a.points[match.a].pt, q = b.points[match.b].pt;
    pairs.push_back({{p.x, p.y}, {q.x, q.y}});
  }
  return pairs;
}

std::vector<Eigen::Vector2d> Corners(const cv::Mat& image) {
  const double w = image.cols - 1, h = image.rows - 1;
  return {{0, 0}, {w, 0}, {w, h}, {0, h}};
}

// The mean distance between where two homographies take the corners of an image.
double CornerError(const Eigen::Matrix3d& H, const Eigen::Matrix3d& truth, const cv::Mat& image) {
  double sum = 0;
  for (const Eigen::Vector2d& corner : Corners(image))
    sum += (Transfer(H, corner) - Transfer(truth, corner)).norm() / 4;
  return sum;
}

// Where the box's corners are in the scene: the mean of what two independent methods say, which differ by up to 1.1
// px. SIFT with findHomography by USAC_MAGSAC: (118.80, 160.90) (284.00, 175.18) (267.43, 297.93) (89.62, 272.07);
// the grey levels themselves, by findTransformECC: (117.76, 160.56) (284.21, 175.14) (267.45, 297.96) (90.21, 271.56).
const std::vector<Eigen::Vector2d> kBoxInScene = {
    {118.3, 160.7}, {284.1, 175.2}, {267.4, 297.9}, {89.9, 271.8}};

struct Sample {
  FeatureDetector detector;
  double box_px, graf_px;  // up to which the corners may be off
};

class OpenCvSamples : public ::testing::TestWithParam<Sample> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kSamples / "box.png")) GTEST_SKIP() << "without opencv-doc (packages.txt)";
    if (!IsAvailable(GetParam().detector)) GTEST_SKIP() << "this build has no dlib";
  }
};

TEST_P(OpenCvSamples, TheBoxIsFoundInTheScene) {
  const cv::Mat box = Grey("box.png"), scene = Grey("box_in_scene.png");
  const Features a = Detect(box, {GetParam().detector, 2000}), b = Detect(scene, {GetParam().detector, 2000});
  const std::vector<PointPair> pairs = Paired(a, b, MatchFeatures(a, b, {}));
  const auto found = MsacHomography(pairs, {.threshold = 3, .max_trials = 2000}, 1);
  ASSERT_TRUE(found);
  double error = 0;
  for (int k = 0; k < 4; ++k) error += (Transfer(found->H, Corners(box)[k]) - kBoxInScene[k]).norm() / 4;
  EXPECT_LT(error, GetParam().box_px);
  EXPECT_GT(found->inliers.size(), pairs.size() / 2);
  RecordProperty("box", fmt::format("{} of {} matches, corners off by {:.2f} px", found->inliers.size(),
                                    pairs.size(), error));
}

TEST_P(OpenCvSamples, TheWallIsTakenAsThePublishedHomographySays) {
  const cv::Mat from = Grey("graf1.png"), to = Grey("graf3.png");
  Eigen::Matrix3d truth;
  cv::Mat published;
  cv::FileStorage(((kSamples / "H1to3p.xml")).string(), cv::FileStorage::READ)["H13"] >> published;
  cv::cv2eigen(published, truth);
  const Features a = Detect(from, {GetParam().detector, 3000}), b = Detect(to, {GetParam().detector, 3000});
  const std::vector<PointPair> pairs = Paired(a, b, MatchFeatures(a, b, {}));
  const auto found = MsacHomography(pairs, {.threshold = 4, .max_trials = 20000}, 1);
  ASSERT_TRUE(found);
  const double error = CornerError(found->H, truth, from);
  EXPECT_LT(error, GetParam().graf_px);
  RecordProperty("graf", fmt::format("{} of {} matches, corners off by {:.2f} px", found->inliers.size(),
                                     pairs.size(), error));
}

INSTANTIATE_TEST_SUITE_P(Features, OpenCvSamples,
                         ::testing::Values(Sample{FeatureDetector::kSift, 2, 3},
                                           Sample{FeatureDetector::kSurf, 2, 3},
                                           Sample{FeatureDetector::kOrb, 3, 3},
                                           Sample{FeatureDetector::kAkaze, 2, 3}),
                         [](const auto& each) { return NameOf(each.param.detector); });

}  // namespace
}  // namespace kestrel::vision
