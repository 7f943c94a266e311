// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/pad_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/vision/landmark/pad_photographer.h"
#include "tests/vision/landmark/pose_difference.h"

namespace kestrel::vision {
namespace {

using Eigen::Vector3d;

struct Errors {
  double place_m, turn_rad;
};
Errors ErrorsOf(const PadObservation& seen, const Pose& truth) {
  return {(seen.X_CT.p - truth.p).norm(), LogRotation(seen.X_CT.R * truth.R.conjugate()).norm()};
}

class PadTrackerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    reference_ = new PadReference(MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m));
    photographer_ = new PadPhotographer(PadPicture());
    ground_ = new PadPhotographer({});
  }
  static void TearDownTestSuite() {
    delete ground_;
    delete photographer_;
    delete reference_;
  }
  static PadTracker NewTracker(const PadTrackerOptions& options = {}) {
    return {*reference_, kPadCamera, options};
  }

  // The pad with a sheet over the share of its length that is nearest to the picture's bottom.
  static PadPhotographer Covered(double share, bool textured) {
    cv::Mat picture = PadPicture();
    const int from = static_cast<int>((1 - share) * picture.rows);
    cv::Mat sheet = picture.rowRange(from, picture.rows);
    sheet.setTo(15);
    if (textured) {
      cv::Mat blotches(sheet.rows / 40, sheet.cols / 40, CV_8UC1);
      cv::RNG(3).fill(blotches, cv::RNG::UNIFORM, 0, 256);
      cv::resize(blotches, sheet, sheet.size(), 0, 0, cv::INTER_NEAREST);
    }
    return PadPhotographer(picture);
  }

  static const PadReference* reference_;
  static const PadPhotographer *photographer_, *ground_;
};
const PadReference* PadTrackerTest::reference_;
const PadPhotographer *PadTrackerTest::photographer_, *PadTrackerTest::ground_;

TEST_F(PadTrackerTest, FollowsThePadWithinMillimetresAndFindsItOnce) {
  PadTracker tracker = NewTracker();
  for (int frame = 0; frame < 40; ++frame) {
    const Pose truth = PathPose(frame);
    const auto seen = tracker.Track(photographer_->At(truth, frame), std::nullopt);
    ASSERT_TRUE(seen) << frame;
    EXPECT_EQ(seen->found, frame == 0) << frame;
    EXPECT_TRUE(seen->registered) << frame;
    const auto [place, turn] = ErrorsOf(*seen, truth);
    EXPECT_LT(place, 0.004) << frame;
    EXPECT_LT(Degrees(turn), 0.12) << frame;
    EXPECT_LT(seen->residual_px, 0.5) << frame;
    EXPECT_GT(seen->visible, 0.6) << frame;
    EXPECT_LE(seen->visible, 1) << frame;
    EXPECT_EQ(tracker.inlier_points().size(), static_cast<std::size_t>(seen->inliers));
    EXPECT_GE(tracker.tracked_points().size(), tracker.inlier_points().size());
  }
}

TEST_F(PadTrackerTest, FollowsThePadAtEveryHeight) {
  for (const double height : {1.2, 2.0, 3.0, 6.0, 9.0, 13.0}) {
    PadTracker tracker = NewTracker();
    for (int frame = 0; frame < 4; ++frame) {
      const Pose truth =
          PadBelow({0.02 * frame, -0.01 * frame, height + 0.02 * frame}, 3 + frame, 0.5 * frame);
      const auto seen = tracker.Track(photographer_->At(truth, frame), truth);
      ASSERT_TRUE(seen) << height;
      // the depth of a small pad is known to the square of its distance, its direction to a tenth of a pixel
      const Vector3d off = seen->X_CT.p - truth.p;
      EXPECT_LT(off.head<2>().norm(), 0.0001 * height + 0.0003) << height;
      EXPECT_LT(std::abs(off.z()), 0.00015 * height * height + 0.0005) << height;
    }
  }
}

// The place of a camera over a small pad follows from its lean, and its lean from shifts of hundredths of a pixel. A
// reference that is drawn too coarsely shifts as much, by how the pad falls onto the pixels; so does a corner near the
// rim, by the ground about it.
TEST_F(PadTrackerTest, FromFarAboveThePadItsLeanIsKnownWhereverOnThePixelsItFalls) {
  for (const double height_m : {9.0, 12.0}) {
    PadTracker tracker = NewTracker();
    cv::RNG random(5);
    double sum_rad2 = 0;
    constexpr int kFrames = 40;
    for (int frame = 0; frame < kFrames; ++frame) {
      const Pose truth = PadBelow({random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), height_m},
                                  20 + frame, random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
      const auto seen = tracker.Track(photographer_->At(truth, frame), std::nullopt);
      ASSERT_TRUE(seen) << height_m << " m, frame " << frame;
      sum_rad2 += std::pow(ErrorsOf(*seen, truth).turn_rad, 2);
    }
    EXPECT_LT(Degrees(std::sqrt(sum_rad2 / kFrames)), 0.25) << height_m << " m";
  }
}

// sigma_px bounds it from below, so on these clean images it may be a few times what the errors are, and
// never less.
TEST_F(PadTrackerTest, CovarianceCoversTheErrors) {
  PadTracker tracker = NewTracker();
  double nees = 0;
  constexpr int kFrames = 30;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Pose truth = PathPose(3 * frame);
    const auto seen = tracker.Track(photographer_->At(truth, frame), truth);
    ASSERT_TRUE(seen);
    const Eigen::Matrix<double, 6, 1> off = Between(truth, seen->X_CT);
    nees += off.dot(seen->covariance.inverse() * off) / kFrames;
  }
  EXPECT_GT(nees, 0.25);
  EXPECT_LT(nees, 6 + 4 * std::sqrt(2 * 6.0 / kFrames));
}

TEST_F(PadTrackerTest, FollowsThePadUnderASheetOverMostOfIt) {
  for (const bool textured : {false, true}) {
    const PadPhotographer covered = Covered(0.7, textured);
    PadTracker tracker = NewTracker();
    for (int frame = 0; frame < 16; ++frame) {
      const Pose truth = PathPose(frame, 3.5);
      const auto seen = tracker.Track((frame < 4 ? *photographer_ : covered).At(truth, frame), std::nullopt);
      ASSERT_TRUE(seen) << frame << textured;
      const auto [place, turn] = ErrorsOf(*seen, truth);
      EXPECT_LT(place, frame < 4 ? 0.004 : 0.01) << frame << textured;
      EXPECT_LT(Degrees(turn), frame < 4 ? 0.12 : 0.3) << frame << textured;
      EXPECT_LT(seen->visible, frame < 4 ? 1 : 0.4) << frame << textured;
    }
  }
}

// Swung to and fro at 30 images a second, each exposed for 0.6 of the time between them: up to 20 px of blur.
TEST_F(PadTrackerTest, FewCornersThatMotionBlurLeavesDoNotMislead) {
  constexpr int kInstants = 8;
  const auto at = [](double frame) {
    return PadBelow({0.5 * std::sin(0.27 * frame) * std::min(1.0, frame / 15), 0.05, 4.2}, 40);
  };
  PadTracker tracker = NewTracker();
  for (int frame = 0; frame < 40; ++frame) {
    cv::Mat light(kPadCamera.height_px, kPadCamera.width_px, CV_32FC1, cv::Scalar(0)), image;
    for (int i = 0; i < kInstants; ++i)
      cv::accumulate(photographer_->At(at(frame + 0.6 * ((i + 0.5) / kInstants - 0.5)), frame), light);
    light.convertTo(image, CV_8U, 1.0 / kInstants);
    const auto seen = tracker.Track(image, std::nullopt);
    ASSERT_TRUE(seen) << frame;
    const auto [place, turn] = ErrorsOf(*seen, at(frame));
    EXPECT_LT(place, 0.02) << frame;
    EXPECT_LT(Degrees(turn), 1) << frame;
  }
}

TEST_F(PadTrackerTest, SaysNoneOnceThePadIsHiddenAndFindsItAgain) {
  const PadPhotographer dark(cv::Mat(1190, 910, CV_8UC1, cv::Scalar(15)));
  for (const PadPhotographer* hiding : {ground_, &dark}) {
    PadTracker tracker = NewTracker();
    for (int frame = 0; frame < 24; ++frame) {
      const Pose truth = PathPose(frame);
      const bool hidden = frame >= 4 && frame < 20;
      const auto seen = tracker.Track((hidden ? *hiding : *photographer_).At(truth, frame), std::nullopt);
      if (hidden) {
        EXPECT_FALSE(seen) << frame;
        EXPECT_TRUE(tracker.inlier_points().empty()) << frame;
      } else {
        ASSERT_TRUE(seen) << frame;
        EXPECT_EQ(seen->found, frame == 0 || frame == 20) << frame;
        EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.004) << frame;
      }
    }
  }
}

TEST_F(PadTrackerTest, SaysNoneWhereThereIsNoPad) {
  cv::Mat mirrored;
  cv::flip(PadPicture(), mirrored, 1);
  const PadPhotographer mirror(mirrored), white(cv::Mat(1190, 910, CV_8UC1, cv::Scalar(255)));
  for (const PadPhotographer* scene : {ground_, &mirror, &white}) {
    for (const bool registration : {true, false}) {
      PadTracker tracker = NewTracker({.registration = registration});
      for (int frame = 0; frame < 3; ++frame) {
        EXPECT_FALSE(tracker.Track(scene->At(PathPose(frame), frame), std::nullopt));
        EXPECT_FALSE(
            tracker.Track(scene->At(PathPose(frame), frame), PathPose(frame)));  // even where it is expected
      }
    }
  }
}

TEST_F(PadTrackerTest, SurvivesAChangeOfExposure) {
  PadTracker tracker = NewTracker();
  for (int frame = 0; frame < 16; ++frame) {
    const Pose truth = PathPose(frame);
    const bool changed = frame >= 4 && frame < 10;
    const cv::Mat image = photographer_->At(truth, frame, changed ? 0.7 : 1, changed ? 20 : 0);
    const auto seen = tracker.Track(image, std::nullopt);
    ASSERT_TRUE(seen) << frame;
    EXPECT_TRUE(seen->registered) << frame;
    EXPECT_EQ(seen->found, frame == 0) << frame;
    EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.004) << frame;
  }
}

TEST_F(PadTrackerTest, FollowsThePadInDimAndInPaleLight) {
  for (const auto& [gain, offset] : {std::pair{0.3, 5.0}, std::pair{0.35, 150.0}}) {
    PadTracker tracker = NewTracker();
    for (int frame = 0; frame < 8; ++frame) {
      const Pose truth = PathPose(frame);
      const auto seen = tracker.Track(photographer_->At(truth, frame, gain, offset), std::nullopt);
      ASSERT_TRUE(seen) << frame << ' ' << gain;
      EXPECT_EQ(seen->found, frame == 0) << frame << ' ' << gain;
      EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.006) << frame << ' ' << gain;
    }
  }
}

TEST_F(PadTrackerTest, FollowsBothHalvesOfAPadThatIsHalfInTheShade) {
  for (const double light : {0.5, 0.3}) {
    const PadPhotographer shaded(HalfInTheShade(PadPicture(), light));
    PadTracker tracker = NewTracker();
    for (int frame = 0; frame < 12; ++frame) {
      const Pose truth = PathPose(frame + 100, 3.2);
      const auto seen = tracker.Track(shaded.At(truth, frame), std::nullopt);
      ASSERT_TRUE(seen) << light << " in " << frame;
      EXPECT_EQ(seen->found, frame == 0) << light << " in " << frame;
      EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.006) << light << " in " << frame;
      EXPECT_GT(seen->visible, 0.6) << light << " in " << frame;
    }
  }
}

// Too small, dim and broken by the shade's edge for its frame, or for features of half the image's size, to tell.
TEST_F(PadTrackerTest, FindsASmallPadHalfInTheShadeOfADimImage) {
  cv::Mat printed = PadPicture();
  printed.convertTo(printed, CV_8U, (214 - 28) / 255.0, 28);
  const PadPhotographer shaded(HalfInTheShade(printed, 0.5));
  for (const double yaw_deg : {-160.0, -50.0, 20.0, 110.0}) {
    PadTracker tracker = NewTracker();
    std::optional<PadObservation> seen;
    Pose truth;
    for (int frame = 0; frame < 40 && !seen; ++frame) {
      truth = PadBelow({1.8 - 0.02 * frame, -2.2, 9}, yaw_deg);
      cv::Mat image;
      cv::GaussianBlur(shaded.At(truth, frame, 0.5), image, {}, 0.9);
      seen = tracker.Track(image, std::nullopt);
    }
    ASSERT_TRUE(seen) << yaw_deg;
    EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.15) << yaw_deg;
  }
}

// Its finest details, which the reference has, are not in the image.
TEST_F(PadTrackerTest, FollowsABlurredPrintDownToTheGround) {
  cv::Mat grain(PadPicture().size() / 4, CV_32FC1), printed, spread;
  cv::RNG(5).fill(grain, cv::RNG::NORMAL, 0, 9);  // of paper and ink
  cv::resize(grain, grain, PadPicture().size(), 0, 0, cv::INTER_NEAREST);
  PadPicture().convertTo(printed, CV_32F, (214 - 28) / 255.0, 28);
  cv::GaussianBlur(printed + grain, spread, {}, 3);
  spread.convertTo(spread, CV_8U);
  const PadPhotographer blurred(HalfInTheShade(spread, 0.3));
  PadTracker tracker = NewTracker();
  for (int frame = 0; frame < 28; ++frame) {
    const double height = 0.8 - 0.02 * frame;
    const Pose truth = PadBelow({0.05 - 0.003 * frame, -0.03 + 0.002 * frame, height}, 30 + 0.3 * frame);
    cv::Mat image;
    cv::GaussianBlur(blurred.At(truth, frame), image, {}, 1.5);
    const auto seen = tracker.Track(image, frame == 0 ? std::optional(truth) : std::nullopt);
    ASSERT_TRUE(seen) << height;
    EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.004) << height;
  }
}

TEST_F(PadTrackerTest, SearchesAnewAfterALoss) {
  for (const bool registration : {true, false}) {
    PadTracker tracker = NewTracker({.registration = registration});
    const Pose truth = PathPose(0);
    ASSERT_TRUE(tracker.Track(photographer_->At(truth, 0), std::nullopt));
    EXPECT_FALSE(tracker.Track(ground_->At(truth, 1), std::nullopt));
    const auto seen = tracker.Track(photographer_->At(truth, 2), std::nullopt);  // where it was
    ASSERT_TRUE(seen);
    EXPECT_TRUE(seen->found);
  }
}

// The chain of eq. (3.20) adds the errors of its links; the reference has only its own.
TEST_F(PadTrackerTest, RegistrationTakesAwayTheDriftOfTheChain) {
  PadTracker registered = NewTracker(), chained = NewTracker({.registration = false});
  double registered_error = 0, chained_error = 0;
  constexpr int kFrames = 90, kLast = 15;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Pose truth = PathPose(frame);
    const cv::Mat image = photographer_->At(truth, frame);
    const auto with = registered.Track(image, std::nullopt), without = chained.Track(image, std::nullopt);
    ASSERT_TRUE(with && without) << frame;
    EXPECT_EQ(without->registered, frame == 0) << frame;  // the search alone looks at the reference
    if (frame < kFrames - kLast) continue;
    registered_error += ErrorsOf(*with, truth).turn_rad / kLast;
    chained_error += ErrorsOf(*without, truth).turn_rad / kLast;
  }
  EXPECT_GT(chained_error, 4 * registered_error);
  RecordProperty("registered_deg", std::to_string(Degrees(registered_error)));
  RecordProperty("chained_deg", std::to_string(Degrees(chained_error)));
}

TEST_F(PadTrackerTest, AnExpectedPoseCarriesItOverALeap) {
  PadTracker tracker = NewTracker();
  ASSERT_TRUE(tracker.Track(photographer_->At(PadBelow({-0.6, 0.3, 4}, 10), 1), std::nullopt));
  const Pose truth = PadBelow({0.6, -0.3, 4}, 55, 5);
  const Pose expected{ExpRotation({0.003, -0.003, 0.01}) * truth.R, truth.p + Vector3d(0.01, 0.01, -0.03)};
  const auto seen = tracker.Track(photographer_->At(truth, 2), expected);
  ASSERT_TRUE(seen);
  EXPECT_FALSE(seen->found);
  EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.004);
}

TEST_F(PadTrackerTest, AWrongExpectationDoesNotMisleadIt) {
  PadTracker tracker = NewTracker();
  for (int frame = 0; frame < 5; ++frame) {
    const Pose truth = PathPose(frame);
    const auto seen = tracker.Track(photographer_->At(truth, frame), PadBelow({-1, 0.7, 6}, -120));
    ASSERT_TRUE(seen) << frame;
    EXPECT_LT(ErrorsOf(*seen, truth).place_m, 0.004) << frame;
  }
}

TEST_F(PadTrackerTest, TheSameImagesGiveTheSameBits) {
  PadTracker first = NewTracker(), again = NewTracker();
  for (int frame = 0; frame < 6; ++frame) {
    const cv::Mat image = photographer_->At(PathPose(frame), frame);
    const auto a = first.Track(image, std::nullopt), b = again.Track(image, std::nullopt);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->X_CT.p, b->X_CT.p);
    EXPECT_EQ(a->X_CT.R.coeffs(), b->X_CT.R.coeffs());
    EXPECT_EQ(a->covariance, b->covariance);
    EXPECT_EQ(a->H_w, b->H_w);
  }
}

}  // namespace
}  // namespace kestrel::vision
