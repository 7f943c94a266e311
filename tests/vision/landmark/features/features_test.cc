// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/features/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <vector>

#include "tests/vision/landmark/pad_photographer.h"
#include "vision/landmark/pad_features.h"

namespace kestrel::vision {
namespace {

constexpr FeatureDetector kAll[] = {FeatureDetector::kSift, FeatureDetector::kSurf, FeatureDetector::kOrb,
                                    FeatureDetector::kAkaze};

cv::Mat Picture() {
  cv::Mat small;
  cv::resize(PadPicture(), small, {320, 416}, 0, 0, cv::INTER_AREA);
  return small;
}
bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

class EveryDetector : public ::testing::TestWithParam<FeatureDetector> {
 protected:
  void SetUp() override {
    if (!IsAvailable(GetParam())) GTEST_SKIP() << "this build has no dlib";
  }
};

// A picture turned by 30 degrees and made smaller: most pairs are those that the turn makes.
TEST_P(EveryDetector, KnowsAPictureAgainThatIsTurnedAndSmaller) {
  const cv::Mat picture = Picture();
  const cv::Mat map = cv::getRotationMatrix2D({160, 208}, 30, 0.8);
  cv::Mat turned;
  cv::warpAffine(picture, turned, map, picture.size(), cv::INTER_AREA, cv::BORDER_REPLICATE);
  const Features a = Detect(picture, {GetParam(), 600}), b = Detect(turned, {GetParam(), 600});
  int right = 0;
  const auto matches = MatchFeatures(a, b, {});
  for (const Match& match : matches) {
    const cv::Point2f p = a.points[match.a].pt, q = b.points[match.b].pt;
    const double u = map.at<double>(0, 0) * p.x + map.at<double>(0, 1) * p.y + map.at<double>(0, 2);
    const double v = map.at<double>(1, 0) * p.x + map.at<double>(1, 1) * p.y + map.at<double>(1, 2);
    right += std::hypot(q.x - u, q.y - v) < 3;
  }
  EXPECT_GT(right, 20);
  EXPECT_GT(right, 0.7 * static_cast<double>(matches.size()));
}

TEST_P(EveryDetector, TheSameImageGivesTheSameBitsOnAnyNumberOfThreads) {
  const cv::Mat picture = Picture();
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const Features one = Detect(picture, {GetParam(), 300});
  cv::setNumThreads(3);
  const Features three = Detect(picture, {GetParam(), 300});
  cv::setNumThreads(threads);
  ASSERT_GT(one.points.size(), 50u);
  ASSERT_EQ(one.points.size(), three.points.size());
  for (std::size_t i = 0; i < one.points.size(); ++i) {
    EXPECT_EQ(one.points[i].pt, three.points[i].pt);
    EXPECT_EQ(one.points[i].angle, three.points[i].angle);
  }
  EXPECT_TRUE(SameBits(one.descriptors, three.descriptors));
}

TEST_P(EveryDetector, GivesTheStrongestUpToTheLimit) {
  const Features few = Detect(Picture(), {GetParam(), 100});
  EXPECT_LE(few.points.size(), 110u);  // of equal strength there may be more
  EXPECT_GT(few.points.size(), 40u);
  EXPECT_EQ(few.descriptors.rows, static_cast<int>(few.points.size()));
}

TEST_P(EveryDetector, FindsNothingInABlankImage) {
  const Features none = Detect(cv::Mat(200, 300, CV_8UC1, cv::Scalar(90)), {GetParam(), 100});
  EXPECT_TRUE(none.points.empty());
  EXPECT_TRUE(MatchFeatures(none, Detect(Picture(), {GetParam(), 100}), {}).empty());
  EXPECT_TRUE(MatchFeatures(Detect(Picture(), {GetParam(), 100}), none, {.mutual = true}).empty());
}

TEST_P(EveryDetector, TheApproximateMatcherFindsMostOfWhatBruteForceFindsAndTheSameEachTime) {
  const cv::Mat picture = Picture();
  cv::Mat noisy, noise(picture.size(), CV_8UC1);
  cv::RNG(4).fill(noise, cv::RNG::UNIFORM, 0, 12);
  cv::add(picture, noise, noisy);
  const Features a = Detect(picture, {GetParam(), 500}), b = Detect(noisy, {GetParam(), 500});
  const auto every = MatchFeatures(a, b, {});
  const MatchOptions approximate{.matcher = FeatureMatcher::kKdTree};
  cv::theRNG() = cv::RNG(1);
  const auto first = MatchFeatures(a, b, approximate);
  const auto after = cv::theRNG().state;
  EXPECT_EQ(after, cv::RNG(1).state);  // the thread's generator is left as it was
  cv::theRNG() = cv::RNG(2);
  const auto again = MatchFeatures(a, b, approximate);
  EXPECT_EQ(first, again);
  std::set<std::pair<int, int>> found;
  for (const Match& match : first) found.emplace(match.a, match.b);
  int common = 0;
  for (const Match& match : every) common += found.contains({match.a, match.b});
  ASSERT_GT(every.size(), 40u);
  EXPECT_GT(common, 0.85 * static_cast<double>(every.size()));
}

// A third of the pad lies beyond the image's edge. All but SIFT see it from near alone, and less exactly: what
// they find is registered afterwards.
TEST_P(EveryDetector, FindsAPadOfWhichAPartIsInView) {
  static const PadReference reference = MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m);
  static const PadPhotographer photographer(PadPicture());
  const PadFeatures features(reference, kPadCamera, GetParam());
  const bool exact = GetParam() == FeatureDetector::kSift;
  for (const double height : {2.5, 4.0}) {
    if (!exact && height > 3) continue;
    const Pose truth = PadBelow({0.36 * height, -0.1, height}, 30, 4, 3);
    const auto H = features.Find(photographer.At(truth, 3), 1);
    ASSERT_TRUE(H) << height;
    Eigen::Matrix3d M;
    M << truth.R.toRotationMatrix().leftCols<2>(), truth.p;
    const Eigen::Matrix3d H_true = kPadCamera.K() * M;
    for (const Eigen::Vector2d& corner : reference.Outline()) {
      const Eigen::Vector2d at = (H_true * corner.homogeneous()).hnormalized();
      if (at.x() > kPadCamera.width_px) continue;
      EXPECT_LT(((*H * corner.homogeneous()).hnormalized() - at).norm(), exact ? 3 : 6) << height;
    }
  }
}

// Those of a reference are kept: it is found by its own all the same, after another one and again.
TEST(PadFeatures, AreThoseOfTheirReference) {
  static const PadReference pad = MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m);
  cv::Mat turned;
  cv::rotate(PadPicture(), turned, cv::ROTATE_180);
  const PadReference upside_down = MakePadReference(turned, kPadLength_m, kPadWidth_m);
  const cv::Mat image = PadPhotographer(PadPicture()).At(PadBelow({0, 0, 2.5}, 10), 3);
  const auto first = PadFeatures(pad, kPadCamera).Find(image, 1);
  const auto other = PadFeatures(upside_down, kPadCamera).Find(image, 1);
  const auto again = PadFeatures(pad, kPadCamera).Find(image, 1);
  ASSERT_TRUE(first && other && again);
  EXPECT_EQ(*first, *again);
  const Eigen::Vector2d top = (*first * Eigen::Vector3d(0.5, 0, 1)).hnormalized();
  const Eigen::Vector2d bottom = (*other * Eigen::Vector3d(-0.5, 0, 1)).hnormalized();
  EXPECT_LT((top - bottom).norm(), 2);
}

INSTANTIATE_TEST_SUITE_P(Features, EveryDetector, ::testing::ValuesIn(kAll),
                         [](const auto& each) { return NameOf(each.param); });

Features OfRows(const std::vector<std::vector<float>>& rows) {
  Features features;
  features.descriptors.create(static_cast<int>(rows.size()), static_cast<int>(rows[0].size()), CV_32F);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    features.points.emplace_back(static_cast<float>(i), 0.F, 1.F);
    for (std::size_t k = 0; k < rows[i].size(); ++k)
      features.descriptors.at<float>(static_cast<int>(i), static_cast<int>(k)) = rows[i][k];
  }
  return features;
}

TEST(MatchFeatures, KeepsWhatIsDistinctAndWhatIsMutualWhereAsked) {
  const Features a = OfRows({{0, 0}, {10, 0}, {5, 0}, {0.5, 0}});
  const Features b = OfRows({{0, 1}, {10, 1}});
  using Matches = std::vector<std::pair<int, int>>;
  const auto pairs = [&](const MatchOptions& options) {
    Matches all;
    for (const Match& match : MatchFeatures(a, b, options)) all.emplace_back(match.a, match.b);
    return all;
  };
  EXPECT_EQ(pairs({.ratio = 0.8F}), (Matches{{0, 0}, {1, 1}, {3, 0}}));  // the third is as near to both
  EXPECT_EQ(pairs({.ratio = 1}), (Matches{{0, 0}, {1, 1}, {2, 0}, {3, 0}}));
  EXPECT_EQ(pairs({.ratio = 1, .mutual = true}), (Matches{{0, 0}, {1, 1}}));
}

TEST(FeatureDetectorNamed, KnowsItsNamesAlone) {
  for (const FeatureDetector detector : kAll) EXPECT_EQ(FeatureDetectorNamed(NameOf(detector)), detector);
  EXPECT_FALSE(FeatureDetectorNamed("brisk"));
  EXPECT_EQ(FeatureDetectorNames().size(), std::size(kAll));
}

}  // namespace
}  // namespace kestrel::vision
