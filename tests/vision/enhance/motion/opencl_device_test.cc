// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/opencl_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tests/vision/enhance/motion/random_scene.h"
#include "vision/enhance/motion/image_motion.h"
#include "vision/enhance/motion/point_flow.h"

namespace kestrel::vision {
namespace {

const cv::Matx23d kTruth(1.005, 0.01, 3.3, -0.01, 0.995, -2.6);

class OpenCl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!OpenClDevice()) GTEST_SKIP() << "no device of OpenCL (pocl-opencl-icd makes the processor one)";
    cv::warpAffine(before_, after_, kTruth, before_.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  }
  const cv::Mat before_ = RandomScene({320, 240}, 1);
  cv::Mat after_;
};

// OpenCL's kernel stops and interpolates otherwise, and treats windows across the image's rim otherwise, so that it is
// compared within: most points differ by hundredths of a pixel, and both are where they were moved to.
TEST_F(OpenCl, FollowsPointsWhereTheProcessorDoes) {
  constexpr int kRim_px = 40;
  std::vector<cv::Point2f> points;
  cv::Mat within(before_.size(), CV_8U, cv::Scalar(0));
  within(cv::Rect(kRim_px, kRim_px, 320 - 2 * kRim_px, 240 - 2 * kRim_px)) = 255;
  cv::goodFeaturesToTrack(before_, points, 100, 0.01, 5, within);
  ASSERT_EQ(points.size(), 100u);
  for (const bool guessed : {false, true}) {
    std::vector<std::vector<cv::Point2f>> ends;
    for (const bool opencl : {false, true}) {
      const FlowOptions options{.opencl = opencl};
      const FlowPyramid from(before_, options), to(after_, options);
      std::vector<cv::Point2f>& end = ends.emplace_back();
      if (guessed)
        for (const cv::Point2f& p : points) end.push_back(p + cv::Point2f(2, -2));
      const auto found = FollowPoints(from, to, points, end);
      ASSERT_EQ(end.size(), points.size());
      EXPECT_EQ(std::count(found.begin(), found.end(), 1), 100);
    }
    EXPECT_EQ(OpenClStateNow(), OpenClState::kUsed) << NameOf(OpenClStateNow());
    std::vector<double> apart, off;
    for (std::size_t i = 0; i < points.size(); ++i) {
      apart.push_back(cv::norm(ends[0][i] - ends[1][i]));
      const cv::Vec2d truth = kTruth * cv::Vec3d(points[i].x, points[i].y, 1);
      off.push_back(std::hypot(ends[1][i].x - truth[0], ends[1][i].y - truth[1]));
    }
    std::sort(apart.begin(), apart.end()), std::sort(off.begin(), off.end());
    EXPECT_LT(apart[50], 0.02);
    EXPECT_LT(apart[95], 0.1);
    EXPECT_LT(off[95], 0.15);
    EXPECT_GT(apart.back(), 0);  // it is another program
  }
}

TEST_F(OpenCl, FindsTheMotionOfTheProcessor) {
  std::vector<ImageMotion> motions;
  for (const bool opencl : {false, true}) {
    MotionImage from(before_, true, opencl), to(after_, true, opencl);
    motions.push_back(MotionBetween(from, to, {}, {.opencl = opencl}));
    ASSERT_EQ(motions.back().state, MotionState::kFollowed);
  }
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0, 0), {319, 0}, {0, 239}, {319, 239}})
    EXPECT_LT((Transfer(motions[0].H, p) - Transfer(motions[1].H, p)).norm(), 0.1);
}

TEST_F(OpenCl, LeavesTheRestOfOpenCvOnTheProcessor) {
  const bool before = cv::ocl::useOpenCL();
  bool within = false;
  ASSERT_TRUE(DoByOpenCl([&] { within = cv::ocl::useOpenCL(); }));
  EXPECT_TRUE(within);
  EXPECT_EQ(cv::ocl::useOpenCL(), before);
}

// Last: a device that has failed is not asked again.
TEST_F(OpenCl, ThatFailsIsToldAndTheProcessorGoesOn) {
  const FlowOptions options{.opencl = true};
  const FlowPyramid from(before_, options), to(after_, options);
  EXPECT_FALSE(DoByOpenCl([] { CV_Error(cv::Error::OpenCLApiCallError, "out of resources"); }));
  EXPECT_EQ(OpenClStateNow(), OpenClState::kFailed);
  const std::vector<cv::Point2f> begin = {{160, 120}};
  std::vector<cv::Point2f> end, by_processor;
  ASSERT_EQ(FollowPoints(from, to, begin, end)[0], 1);
  ASSERT_EQ(FollowPoints(FlowPyramid(before_, {}), FlowPyramid(after_, {}), begin, by_processor)[0], 1);
  EXPECT_EQ(end, by_processor);
}

[[noreturn]] void FollowWithoutDevice() {
  setenv("OPENCV_OPENCL_RUNTIME", "disabled", 1);
  const cv::Mat scene = RandomScene({160, 120}, 1);
  const std::vector<cv::Point2f> begin = {{80, 60}};
  std::vector<cv::Point2f> end, by_processor;
  const FlowPyramid image(scene, {.opencl = true}), plain(scene, {});
  const bool found = FollowPoints(image, image, begin, end)[0] == 1;
  FollowPoints(plain, plain, begin, by_processor);
  std::fputs(FlowDevice(true).c_str(), stderr);
  std::exit(found && end == by_processor && OpenClStateNow() == OpenClState::kAbsent ? 0 : 1);
}

// In a process of its own, since a device is looked for once.
TEST(OpenClDeathTest, ThatIsAbsentIsToldAndTheProcessorGoesOn) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(FollowWithoutDevice(), ::testing::ExitedWithCode(0), "processor .OpenCL absent.");
}

}  // namespace
}  // namespace kestrel::vision
