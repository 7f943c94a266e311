// SPDX-License-Identifier: Apache-2.0
// What the stabiliser does where vision finds no motion and attitudes are known.
#include <gtest/gtest.h>

#include "geometry/pose.h"
#include "tests/vision/enhance/motion/random_scene.h"
#include "vision/enhance/stabilisation/stabiliser.h"

namespace kestrel::vision {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;

const Pinhole kPinhole{.width_px = 160, .height_px = 120, .fx = 150, .fy = 150, .cx = 79.5, .cy = 59.5};

class StabiliserThatLosesVision : public ::testing::Test {
 protected:
  StabiliserThatLosesVision() {
    StabiliserOptions options;
    options.mode = "reference", options.by = "both", options.crop = 1, options.scale = false;
    stabiliser_.emplace(options, camera_, 30);
    EXPECT_EQ(Step(scene_, Quaterniond::Identity()).state, StabilisedState::kFirst);
    EXPECT_EQ(Step(scene_, Quaterniond::Identity()).state, StabilisedState::kFollowed);
  }
  StabilisedImage Step(const cv::Mat& image, const Quaterniond& R_NC) {
    return *stabiliser_->Step(image, steps_++ / 30.0, {{R_NC}, {}, 0});
  }
  // How far what the camera sees along a ray of the first image is shown from where that one had it.
  double Off_px(const StabilisedImage& image, const Quaterniond& R_NC) const {
    const Vector2d at(60, 50), seen = *kPinhole.Project(R_NC.conjugate() * *kPinhole.Ray(at));
    return (*ShownAt(image.view, &camera_, seen) - at).norm();
  }

  const CameraModel camera_ = kPinhole;
  const cv::Mat scene_ = RandomScene({160, 120}, 7);
  const Quaterniond turned_ = ExpRotation({0.02, 0.05, -0.1});
  std::optional<Stabiliser> stabiliser_;
  int steps_ = 0;
};

TEST_F(StabiliserThatLosesVision, GoesOnByTheGyroAloneBeforeAFlatWall) {
  const cv::Mat flat(120, 160, CV_8UC1, cv::Scalar(90));
  const StabilisedImage image = Step(flat, turned_);
  EXPECT_EQ(image.state, StabilisedState::kGyroAlone) << NameOf(image.state);
  EXPECT_EQ(image.inliers, 0);
  EXPECT_LT(Off_px(image, turned_), 0.05);
  const StabilisedImage seen_again = Step(scene_, Quaterniond::Identity());
  EXPECT_EQ(seen_again.state, StabilisedState::kFollowed) << NameOf(seen_again.state);
  EXPECT_LT(Off_px(seen_again, Quaterniond::Identity()), 0.1);
}

TEST_F(StabiliserThatLosesVision, KeepsItsReferenceByTheGyroWhereImagesAgreeOnNothing) {
  const StabilisedImage image = Step(RandomScene({160, 120}, 99), turned_);
  EXPECT_EQ(image.state, StabilisedState::kGyroAlone) << NameOf(image.state);
  EXPECT_LT(Off_px(image, turned_), 0.05);
  const StabilisedImage next = Step(RandomScene({160, 120}, 99), turned_);
  EXPECT_EQ(next.state, StabilisedState::kFollowed) << NameOf(next.state);
  EXPECT_LT(Off_px(next, turned_), 0.1);
}

}  // namespace
}  // namespace kestrel::vision
