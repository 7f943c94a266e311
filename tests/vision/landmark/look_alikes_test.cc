// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/vision/landmark/pad_photographer.h"
#include "vision/landmark/look_alike.h"
#include "vision/landmark/pad_features.h"
#include "vision/landmark/pad_tracker.h"
#include "vision/landmark/plane/homography.h"
#include "vision/landmark/plane/plane_pose.h"

// What looks like the pad and is not it.
namespace kestrel::vision {
namespace {

// The helipad by its picture, and a pad by its tag.
struct Kind {
  const char* name;
  cv::Mat picture, other;  // other: of its kind, not it
  PadReference reference;

  PadTracker NewTracker() const { return {reference, kPadCamera, {}}; }
};

// Black and white squares at random in a frame as wide as the helipad's.
cv::Mat OtherPad() {
  cv::Mat picture(1024, 1024, CV_8UC1, cv::Scalar(255)), squares(16, 16, CV_8UC1);
  cv::RNG(5).fill(squares, cv::RNG::UNIFORM, 0, 256);
  cv::resize(squares, picture(cv::Rect(64, 64, 896, 896)), {896, 896}, 0, 0, cv::INTER_NEAREST);
  cv::rectangle(picture, cv::Rect(32, 32, 960, 960), cv::Scalar(20), 32);
  return picture;
}

const std::vector<Kind>& Kinds() {
  const std::vector<Tag> mine = {{"tag36h11", 3, 0.72, {0, 0}}}, other = {{"tag36h11", 4, 0.72, {0, 0}}};
  const Eigen::Vector2d size_m(kPadLength_m, kPadWidth_m);
  static const std::vector<Kind> kinds = [&] {
    std::vector<Kind> all = {{"picture", PadPicture(), OtherPad(), {}},
                             {"tag", DrawTags(mine, size_m), DrawTags(other, size_m), {}}};
    for (Kind& kind : all) kind.reference = MakePadReference(kind.picture, kPadLength_m, kPadWidth_m);
    all[1].reference.tags = mine;
    return all;
  }();
  return kinds;
}

// One image over another, where that shows no ground.
cv::Mat Together(const cv::Mat& below, const PadPhotographer& above, const Pose& X_CT, int seed) {
  static const PadPhotographer ground{cv::Mat()};
  const cv::Mat image = above.At(X_CT, seed);
  cv::Mat off, together = below.clone();
  cv::absdiff(image, ground.At(X_CT, seed), off);
  image.copyTo(together, off > 0);
  return together;
}

TEST(LookAlikes, ASecondCopyDoesNotTakeThePlaceOfThePad) {
  for (const Kind& kind : Kinds()) {
    const PadPhotographer photographer(kind.picture);
    PadTracker tracker = kind.NewTracker();
    for (int frame = 0; frame < 3; ++frame) {
      const Pose truth = PadBelow({-0.8 + 0.02 * frame, 0, 5}, 3), copy = PadBelow({0.8, 0.1, 5}, 8);
      cv::Mat image = photographer.At(truth, frame);
      if (frame > 0) image = Together(image, photographer, copy, frame);
      const auto seen = tracker.Track(image, std::nullopt);
      ASSERT_TRUE(seen) << kind.name << frame;
      EXPECT_LT((seen->X_CT.p - truth.p).norm(), 0.03) << kind.name << frame;
    }
  }
}

TEST(LookAlikes, AMirroredOneIsNotFound) {
  for (const Kind& kind : Kinds()) {
    for (const int flip : {0, 1}) {
      cv::Mat picture;
      cv::flip(kind.picture, picture, flip);
      const PadPhotographer mirrored(picture);
      PadTracker tracker = kind.NewTracker();
      EXPECT_FALSE(tracker.Track(mirrored.At(PadBelow({0.1, 0, 5}, 10), 2), std::nullopt))
          << kind.name << flip;
    }
  }
}

// Round marks look alike mirrored too, and all of them agree on a pad that is seen from below.
TEST(LookAlikes, FeaturesOfAMirroredOneAreNotTaken) {
  const PadReference reference = MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m);
  const PadFeatures features(reference, kPadCamera);
  for (const int flip : {0, 1}) {
    cv::Mat picture;
    cv::flip(PadPicture(), picture, flip);
    const PadPhotographer mirrored(picture);
    for (int k = 6; k < 14; ++k)
      EXPECT_FALSE(features.Find(mirrored.At(PathPose(112 + k, 4.1), 1600 + k), 1 + k)) << flip << " " << k;
  }
}

TEST(LookAlikes, AnotherPictureInTheSameFrameIsNotTaken) {
  for (const Kind& kind : Kinds()) {
    const PadPhotographer mine(kind.picture), other(kind.other);
    PadTracker tracker = kind.NewTracker();
    const Pose truth = PadBelow({-0.8, 0, 5}, 3), there = PadBelow({0.8, 0.1, 5}, 8);
    EXPECT_FALSE(tracker.Track(other.At(there, 0), std::nullopt)) << kind.name;
    const auto seen = tracker.Track(Together(mine.At(truth, 1), other, there, 1), std::nullopt);
    ASSERT_TRUE(seen) << kind.name;
    EXPECT_LT((seen->X_CT.p - truth.p).norm(), 0.03) << kind.name;
  }
}

// A picture of tiles in a frame: a turned or shifted pose fits them as well, but not the frame.
cv::Mat TiledPicture() {
  cv::Mat tile(64, 64, CV_8UC1, cv::Scalar(200));
  cv::circle(tile, {20, 24}, 11, 50, cv::FILLED);
  cv::rectangle(tile, cv::Rect(36, 34, 18, 16), 95, cv::FILLED);
  cv::Mat picture = cv::repeat(tile, 16, 16);
  cv::rectangle(picture, {16, 16}, {picture.cols - 17, picture.rows - 17}, 20, 32);
  return picture;
}

// Coarsely: its place, also hidden to a third or half in the shade, is not ruled out, and ground and another pad are.
TEST(LookAlikes, ACoarseLookRulesOutWhatIsNotThere) {
  const PadReference reference = MakePadReference(PadPicture(), kPadLength_m, kPadWidth_m);
  cv::Mat hidden = PadPicture();
  hidden.rowRange(0, hidden.rows / 3).setTo(110);
  const PadPhotographer pad(PadPicture()), shaded(HalfInTheShade(PadPicture(), 0.25)), partly(hidden),
      ground{cv::Mat()}, other(OtherPad());
  int ruled_out = 0;
  constexpr int kPoses = 10;
  for (int k = 0; k < kPoses; ++k) {
    const Pose X_CT = PathPose(10 * k, 2 + 0.8 * k);
    const Eigen::Matrix3d H_w = HomographyFromPose(X_CT, kPadCamera);
    for (const PadPhotographer* there : {&pad, &shaded, &partly})
      EXPECT_GT(CoarseLikeness(there->At(X_CT, k), reference, H_w), 0.6) << k;
    for (const PadPhotographer* elsewhere : {&ground, &other})
      ruled_out += CoarseLikeness(elsewhere->At(X_CT, k), reference, H_w) < 0.25;
  }
  EXPECT_GE(ruled_out, 1.8 * kPoses);  // of twice as many
}

// Features of tiles are ambiguous: of the first image already the frame must tell.
TEST(LookAlikes, ThePadOfTilesIsFoundByItsFrameInTheFirstImage) {
  const cv::Mat picture = TiledPicture();
  PadTracker tracker(MakePadReference(picture, kPadLength_m, kPadWidth_m), kPadCamera, {});
  EXPECT_TRUE(tracker.Track(PadPhotographer(picture).At(PadBelow({0.1, 0, 4}, 10), 1), std::nullopt));
}

TEST(LookAlikes, ARimThatDoesNotShowGivesAShiftedPoseAway) {
  const cv::Mat picture = TiledPicture();
  const PadReference reference = MakePadReference(picture, kPadLength_m, kPadWidth_m);
  const PadPhotographer photographer(picture);
  const Pose truth = PadBelow({0.1, 0, 4}, 10), out = PadBelow({1.2, 0, 4}, 10);
  const cv::Mat whole = photographer.At(truth, 1), partly = photographer.At(out, 2);
  const auto agrees = [&](const cv::Mat& image, const Pose& X_CT) {
    return RimAgrees(image, reference, HomographyFromPose(X_CT, kPadCamera));
  };
  EXPECT_TRUE(agrees(whole, truth));
  EXPECT_TRUE(agrees(partly, out));
  for (const double tiles : {1, 2, 3}) {
    const double shift_m = tiles * kPadLength_m / 16;
    for (const Eigen::Vector3d& along :
         {Eigen::Vector3d(shift_m, shift_m, 0), Eigen::Vector3d(shift_m, -shift_m, 0)}) {
      Pose shifted = truth;
      shifted.p += truth.R * along;
      EXPECT_FALSE(agrees(whole, shifted)) << tiles;
    }
  }
  // Where something hides a third of it, it is still the pad.
  cv::Mat hidden = whole.clone();
  const Eigen::Vector2d middle = Transfer(HomographyFromPose(truth, kPadCamera), {0, 0});
  hidden.rowRange(cvRound(middle.y()) + 30, hidden.rows).setTo(120);
  EXPECT_TRUE(agrees(hidden, truth));
}

}  // namespace
}  // namespace kestrel::vision
