// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/alignment/aligner.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

#include "tests/vision/landmark/alignment/analytic_texture.h"
#include "tests/visp/template_tracker.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

const cv::Rect kRegion(60, 50, 100, 80);
const std::vector<AlignmentMethod> kMethods{
    AlignmentMethod::kForwardAdditive, AlignmentMethod::kInverseCompositional, AlignmentMethod::kSecondOrder};
const std::vector<WarpModel> kModels{WarpModel::kTranslation, WarpModel::kEuclidean, WarpModel::kSimilarity,
                                     WarpModel::kAffine, WarpModel::kHomography};

// A warp of the model about the middle of the region, which takes its corners some pixels away.
Matrix3d TrueWarp(WarpModel model) {
  constexpr double kHalf_px = 50;
  WarpParameters p = kNoWarp, some;
  some << 5.3 / kHalf_px, -3.7 / kHalf_px, 0.06, 0.05, -0.03, 0.04, 0.03, -0.02;
  p.head(ParameterCount(model)) = some.head(ParameterCount(model));
  Matrix3d N;
  N << 1 / kHalf_px, 0, -109.5 / kHalf_px, 0, 1 / kHalf_px, -89.5 / kHalf_px, 0, 0, 1;
  Matrix3d W = N.inverse() * ExponentialWarp(p) * N;
  return W / W(2, 2);
}

double CornerError_px(const Matrix3d& W, const Matrix3d& W_truth) {
  double squares = 0;
  for (const int x : {kRegion.x, kRegion.x + kRegion.width - 1}) {
    for (const int y : {kRegion.y, kRegion.y + kRegion.height - 1}) {
      const Eigen::Vector3d at(x, y, 1);
      squares += ((W * at).hnormalized() - (W_truth * at).hnormalized()).squaredNorm() / 4;
    }
  }
  return std::sqrt(squares);
}

Alignment AlignOnce(const cv::Mat& picture, const cv::Mat& image, const AlignmentOptions& options,
                    const Matrix3d& start = Matrix3d::Identity()) {
  ImagePyramid pyramid;
  FillPyramid(image, pyramid);
  return Aligner(picture, kRegion, options).Align(pyramid, start);
}

class AlignerTest : public ::testing::Test {
 protected:
  const AnalyticTexture texture_{1};
  const cv::Mat picture_ = texture_.Image(Matrix3d::Identity());
};

TEST_F(AlignerTest, EachMethodFindsEachWarp) {
  int checked = 0;
  for (const WarpModel model : kModels) {
    const Matrix3d W = TrueWarp(model);
    const cv::Mat image = texture_.Image(W);
    ASSERT_GT(CornerError_px(Matrix3d::Identity(), W), 5);
    for (const AlignmentMethod method : kMethods) {
      for (const bool light : {false, true}) {
        const Alignment a = AlignOnce(picture_, image, {.method = method, .warp = model, .light = light});
        EXPECT_EQ(a.state, AlignmentState::kConverged) << ParameterCount(model) << ' ' << NameOf(a.state);
        EXPECT_LT(CornerError_px(a.W, W), 0.03) << ParameterCount(model) << ' ' << static_cast<int>(method);
        EXPECT_GT(a.correlation, 0.999);
        EXPECT_LT(a.rms_grey, 1);
        EXPECT_GT(a.in_view, 0.99);
        EXPECT_GT(a.iterations, 2);
        EXPECT_NEAR(a.gain, 1, 0.01);
        EXPECT_NEAR(a.offset, 0, 1);
        ++checked;
      }
    }
  }
  EXPECT_EQ(checked, 30);
}

TEST_F(AlignerTest, TheLightIsEstimatedWithTheWarp) {
  const Matrix3d W = TrueWarp(WarpModel::kHomography);
  const cv::Mat image = texture_.Image(W, 0.6, 45);
  for (const AlignmentMethod method : kMethods) {
    const Alignment with = AlignOnce(picture_, image, {.method = method});
    EXPECT_EQ(with.state, AlignmentState::kConverged);
    EXPECT_LT(CornerError_px(with.W, W), 0.03);
    EXPECT_NEAR(with.gain, 0.6, 0.01);
    EXPECT_NEAR(with.offset, 45, 1);
    const Alignment without = AlignOnce(picture_, image, {.method = method, .light = false});
    EXPECT_GT(CornerError_px(without.W, W), 0.1);
  }
}

TEST_F(AlignerTest, RobustWeightsLeaveOutWhatHidesTheTemplate) {
  const Matrix3d W = TrueWarp(WarpModel::kAffine);
  cv::Mat image = texture_.Image(W);
  image(cv::Rect(70, 55, 45, 40)).setTo(240);  // about a fifth
  // Nearer than elsewhere: what hides a part of the template shows as such only once the rest agrees.
  Matrix3d start = W;
  start(0, 2) += 1.5, start(1, 2) -= 1;
  for (const AlignmentMethod method : kMethods) {
    const auto with = [&](AlignmentLoss loss) {
      const AlignmentOptions options{.method = method, .warp = WarpModel::kAffine, .loss = loss, .levels = 2};
      return AlignOnce(picture_, image, options, start);
    };
    const Alignment squares = with(AlignmentLoss::kSquares), tukey = with(AlignmentLoss::kTukey);
    EXPECT_EQ(tukey.state, AlignmentState::kConverged);
    EXPECT_LT(CornerError_px(tukey.W, W), 0.05) << static_cast<int>(method);
    EXPECT_NEAR(tukey.agreeing, 0.75, 0.12);
    EXPECT_GT(CornerError_px(squares.W, W), 0.3);
  }
}

TEST_F(AlignerTest, AnotherPictureOrNoneIsNoAlignment) {
  const AnalyticTexture other(2);
  for (const AlignmentMethod method : kMethods) {
    const Alignment a = AlignOnce(picture_, other.Image(Matrix3d::Identity()), {.method = method});
    EXPECT_EQ(a.state, AlignmentState::kDiverged) << a.correlation;
    cv::Mat flat(picture_.size(), CV_32FC1, cv::Scalar(90));
    EXPECT_EQ(AlignOnce(picture_, flat, {.method = method}).state, AlignmentState::kDiverged);
  }
}

TEST_F(AlignerTest, WhatLeavesTheImageIsSaidToAndWhatIsPartlyInItIsFound) {
  for (const AlignmentMethod method : kMethods) {
    Matrix3d away = Matrix3d::Identity();
    away(0, 2) = 300;
    EXPECT_EQ(AlignOnce(picture_, picture_, {.method = method}, away).state, AlignmentState::kLeftImage);
    Matrix3d half = Matrix3d::Identity();
    half(0, 2) = -110.4;  // its left half is beyond the left edge
    Matrix3d start = half;
    start(0, 2) += 2, start(1, 2) -= 1.5;
    const Alignment a = AlignOnce(picture_, texture_.Image(half), {.method = method}, start);
    EXPECT_EQ(a.state, AlignmentState::kConverged) << NameOf(a.state);
    EXPECT_NEAR(a.in_view, 0.49, 0.03);
    EXPECT_NEAR(a.W(0, 2), half(0, 2), 1);  // beyond the edge it extrapolates
    const Vector2d seen = (a.W * Eigen::Vector3d(140, 90, 1)).hnormalized();
    EXPECT_LT((seen - Vector2d(140 - 110.4, 90)).norm(), 0.05);
  }
}

// The image's own pyramid is entered at the level that fits.
TEST_F(AlignerTest, TheTemplateIsFoundLargerAndSmaller) {
  for (const double scale : {0.45, 1.7, 4.0}) {
    Matrix3d W;
    W << scale, 0, 110 - scale * 109.5, 0, scale, 95 - scale * 89.5, 0, 0, 1;
    Matrix3d start = W;
    start(0, 2) += 2 * scale;
    const Alignment a = AlignOnce(picture_, texture_.Image(W), {}, start);
    EXPECT_EQ(a.state, AlignmentState::kConverged) << scale << ' ' << a.correlation;
    EXPECT_LT(CornerError_px(a.W, W), 0.1 * scale) << scale;
  }
}

TEST_F(AlignerTest, AgreesWithOpenCvAndVisp) {
  const Matrix3d W = TrueWarp(WarpModel::kHomography);
  cv::Mat picture, image;
  picture_.convertTo(picture, CV_8U);
  texture_.Image(W, 1, 0, 2).convertTo(image, CV_8U);
  cv::Mat ecc = (cv::Mat_<float>(3, 3) << 1, 0, kRegion.x, 0, 1, kRegion.y, 0, 0, 1);
  cv::findTransformECC(picture(kRegion), image, ecc, cv::MOTION_HOMOGRAPHY, cv::TermCriteria(3, 100, 1e-7),
                       cv::noArray(), 3);
  Eigen::Matrix3f ecc_W;
  cv::cv2eigen(ecc, ecc_W);
  Matrix3d from_picture = Matrix3d::Identity();
  from_picture(0, 2) = -kRegion.x, from_picture(1, 2) = -kRegion.y;
  const visp::GreyImage reference{picture.data, picture.cols, picture.rows},
      seen{image.data, image.cols, image.rows};
  const auto visp = [&](visp::TemplateMethod method) {
    const double left = kRegion.x, top = kRegion.y, right = left + kRegion.width - 1,
                 bottom = top + kRegion.height - 1;
    return visp::TemplateTracker(method, reference,
                                 {{{left, top}, {right, top}, {right, bottom}, {left, bottom}}}, 3)
        .Track(seen);
  };
  const auto inverse = visp(visp::TemplateMethod::kInverseCompositional),
             second = visp(visp::TemplateMethod::kSecondOrder);
  ASSERT_TRUE(inverse && second);
  for (const AlignmentMethod method : kMethods) {
    const Alignment a = AlignOnce(picture, image, {.method = method});
    EXPECT_LT(CornerError_px(a.W, W), 0.06);
    EXPECT_LT(CornerError_px(a.W, ecc_W.cast<double>() * from_picture), 0.1);
    EXPECT_LT(CornerError_px(a.W, *inverse), 0.15);
    EXPECT_LT(CornerError_px(a.W, *second), 0.15);
  }
}

TEST_F(AlignerTest, TheSameImageGivesTheSameBitsWhateverCameBefore) {
  const cv::Mat image = texture_.Image(TrueWarp(WarpModel::kAffine), 1, 0, 2);
  for (const AlignmentLoss loss : {AlignmentLoss::kSquares, AlignmentLoss::kTukey}) {
    Aligner aligner(picture_, kRegion, {.loss = loss});
    ImagePyramid pyramid;
    FillPyramid(image, pyramid);
    const Alignment first = aligner.Align(pyramid, Matrix3d::Identity());
    Matrix3d away = Matrix3d::Identity();
    away(0, 2) = 90;
    aligner.Align(pyramid, away);
    FillPyramid(picture_, pyramid);
    aligner.Align(pyramid, away);
    FillPyramid(image, pyramid);
    EXPECT_EQ(aligner.Align(pyramid, Matrix3d::Identity()).W, first.W);
  }
}

}  // namespace
}  // namespace kestrel::vision
