// SPDX-License-Identifier: Apache-2.0
#include "mission/mosaic/mosaic_observer.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "mission/mosaic/mosaic_view.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::mission {
namespace {

const vision::Pinhole kCamera{320, 240, 300, 300, 159.5, 119.5};

// Mottled ground, CV_8UC1.
cv::Mat Ground() {
  cv::Mat ground(400, 700, CV_8UC1), coarse(50, 88, CV_8UC1);
  cv::RNG random(5);
  random.fill(ground, cv::RNG::UNIFORM, 0, 255);
  random.fill(coarse, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(ground, ground, {}, 1.5);
  cv::resize(coarse, coarse, ground.size(), 0, 0, cv::INTER_CUBIC);
  cv::addWeighted(ground, 0.6, coarse, 0.4, 0, ground);
  return ground;
}

class MosaicOfPassedGround : public InTemporaryFolder {
 protected:
  MosaicOfPassedGround() : observer_({}, Parameters(), kCamera, {}, kImages) {}
  static MosaicParameters Parameters() {
    MosaicParameters p;
    p.poses = false, p.chain = true;
    return p;
  }
  // The image moves over the ground by 10 px to the right from one to the next.
  void Pass() {
    const cv::Mat ground = Ground();
    for (int i = 0; i < kImages; ++i) {
      Decision decision;
      const cv::Mat image = ground(cv::Rect(20 + 10 * i, 60, 320, 240)).clone();
      const vision::MosaicStep step = observer_.Add({image, 0.1 * i, 2 * i}, decision);
      EXPECT_TRUE(vision::IsPlaced(step.state)) << i;
      EXPECT_EQ(decision.target, vision::NameOf(step.state));
    }
  }
  static constexpr int kImages = 25;
  MosaicObserver observer_;
};

TEST_F(MosaicOfPassedGround, PlacesEachImageByItsFrame) {
  Pass();
  const auto finished = observer_.Finish();
  ASSERT_TRUE(finished);
  ASSERT_EQ(finished->placed.size(), 25u);
  ASSERT_EQ(finished->chained.size(), 25u);
  EXPECT_FALSE(finished->ground_from_surface);
  const auto place = [&](int i) {
    EXPECT_EQ(finished->placed[static_cast<std::size_t>(i)].sequence, 2 * i);
    return *finished->projection.ToSurface(finished->placed[static_cast<std::size_t>(i)].M_WC,
                                           {159.5, 119.5});
  };
  for (int i = 1; i < kImages; ++i)
    EXPECT_LT((place(i) - place(0) - Eigen::Vector2d(10 * i, 0)).norm(), 0.3) << i;
  MosaicReport report;
  observer_.Fill(report);
  EXPECT_EQ(report.offered, 25);
  EXPECT_EQ(report.placed, 25);
}

TEST_F(MosaicOfPassedGround, LeavesItsPictures) {
  Pass();
  observer_.WriteProducts(folder_);
  const cv::Mat mosaic = cv::imread((folder_ / "mosaic.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_FALSE(mosaic.empty());
  EXPECT_NEAR(mosaic.cols, 320 + 240, 4);
  EXPECT_NEAR(mosaic.rows, 240, 4);
  // It shows what was passed over.
  const cv::Mat ground = Ground()(cv::Rect(20, 60, 560, 240));
  cv::Mat grey = mosaic, score;
  if (mosaic.channels() == 3) cv::cvtColor(mosaic, grey, cv::COLOR_BGR2GRAY);
  cv::matchTemplate(ground, grey(cv::Rect(40, 20, 440, 180)), score, cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::minMaxLoc(score, nullptr, &best);
  EXPECT_GT(best, 0.95);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "mosaic_growth.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mosaic.tif"));  // without poses it lies nowhere
}

TEST_F(MosaicOfPassedGround, TheVideosImageIsOfOneSizeAndChangesWithTheMosaic) {
  EXPECT_TRUE(observer_.ProductImage().empty());
  Decision decision;
  const cv::Mat ground = Ground();
  observer_.Add({ground(cv::Rect(20, 60, 320, 240)).clone(), 0, 0}, decision);
  const cv::Mat first = observer_.ProductImage().clone();
  observer_.Add({ground(cv::Rect(50, 60, 320, 240)).clone(), 0.1, 1}, decision);
  const cv::Mat second = observer_.ProductImage();
  EXPECT_EQ(first.type(), CV_8UC3);
  ASSERT_EQ(first.size(), second.size());
  EXPECT_GT(cv::norm(first, second, cv::NORM_L1), 1e5);
}

TEST_F(MosaicOfPassedGround, WithoutAnImageNothingIsLeft) {
  observer_.WriteProducts(folder_);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  EXPECT_EQ(observer_.Finish(), nullptr);
}

TEST(Tiled, HasRowsOfThree) {
  const cv::Mat one(30, 40, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_TRUE(Tiled({}).empty());
  EXPECT_EQ(Tiled({one}).size(), one.size());
  const cv::Mat four = Tiled({one, one, one, one});
  EXPECT_EQ(four.size(), cv::Size(3 * 40 + 2 * 6, 2 * 30 + 6));
  EXPECT_EQ(four.at<cv::Vec3b>(50, 20), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(four.at<cv::Vec3b>(50, 60), cv::Vec3b(255, 255, 255));
}

}  // namespace
}  // namespace kestrel::mission
