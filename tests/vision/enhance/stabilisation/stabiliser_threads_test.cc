// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tests/vision/enhance/motion/random_scene.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::vision {
namespace {

std::vector<StabilisedImage> Stabilised(int threads) {
  const int before = cv::getNumThreads();
  cv::setNumThreads(threads);
  const cv::Mat scene = RandomScene({500, 400}, 7);
  StabiliserOptions options;
  options.mode = "reference", options.motion.max_points = 300;
  Stabiliser stabiliser(options, {}, 30);
  std::vector<StabilisedImage> all;
  for (int i = 0; i < 8; ++i) {
    const cv::Point place(50 + static_cast<int>(std::lround(30 * std::sin(0.9 * i))), 40 + 5 * i);
    all.push_back(*stabiliser.Step(scene(cv::Rect(place, cv::Size(320, 240))), i / 30.0));
  }
  cv::setNumThreads(before);
  return all;
}

TEST(Stabiliser, ShowsTheSameOnAnyNumberOfThreads) {
  const auto one = Stabilised(1);
  int compared = 0;
  for (const int threads : {2, 4}) {
    const auto many = Stabilised(threads);
    ASSERT_EQ(many.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i, ++compared) {
      EXPECT_EQ(many[i].view.H, one[i].view.H) << i;
      EXPECT_EQ(many[i].inliers, one[i].inliers) << i;
      EXPECT_EQ(cv::norm(many[i].image, one[i].image, cv::NORM_INF), 0) << i;
    }
  }
  EXPECT_EQ(compared, 16);
}

}  // namespace
}  // namespace kestrel::vision
