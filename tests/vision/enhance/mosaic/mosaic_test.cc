// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/mosaic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <stdexcept>

#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "tests/vision/enhance/mosaic/drawn_ground.h"
#include "vision/enhance/mosaic/mosaic_series.h"
#include "vision/landmark/plane/homography.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const DrawnGround& Ground() {
  static const DrawnGround ground;
  return ground;
}

// A lane to the north, and one back beside it: 28 images from 10 m.
std::vector<Pose> TwoLanes() {
  std::vector<Pose> poses;
  for (int i = 0; i < 28; ++i) {
    const bool back = i >= 14;
    const double along = back ? 27 - i : i;
    poses.push_back(DrawnGround::Above(-5 + 0.8 * along, back ? 2.5 : 0, 10 + 0.2 * std::sin(i),
                                       (back ? 180 : 0) + 2 * std::sin(0.5 * i), 2 * std::sin(0.7 * i),
                                       2 * std::cos(0.6 * i)));
  }
  return poses;
}

MosaicOptions WithCamera() {
  MosaicOptions options;
  options.camera = kGroundCamera;
  return options;
}

// RMS distance, in pixels of the first image, of image corners from where they are, after the homography that W is
// free by.
double ErrorOf(const Mosaic& mosaic, const std::vector<Pose>& poses) {
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (const Vector2d& uv : {Vector2d(40, 30), Vector2d(280, 30), Vector2d(280, 210), Vector2d(40, 210)}) {
      const auto place = mosaic.PlaceOf(static_cast<int>(i), uv);
      if (place) pairs.push_back({*place, 40 * Transfer(DrawnGround::GroundFromImage(poses[i]), uv)});
    }
  EXPECT_EQ(pairs.size(), 4 * poses.size());
  const auto H = FitHomography(pairs);
  double squares = 0;
  for (const PointPair& pair : pairs) squares += (Transfer(*H, pair.from) - pair.to).squaredNorm();
  return std::sqrt(squares / static_cast<double>(pairs.size()));
}

Mosaic MosaicOf(const MosaicOptions& options, const std::vector<Pose>& poses) {
  Mosaic mosaic(options);
  int i = 0;
  for (const Pose& pose : poses) {
    const MosaicStep step = mosaic.Add(Ground().Draw(pose), 0.1 * i);
    EXPECT_TRUE(IsPlaced(step.state)) << i << ' ' << NameOf(step.state);
    EXPECT_EQ(step.number, i++);
  }
  mosaic.Adjust();
  return mosaic;
}

TEST(MosaicTest, ImagesLieWhereTheyWereTaken) {
  const std::vector<Pose> poses = TwoLanes();
  const Mosaic mosaic = MosaicOf(WithCamera(), poses);
  EXPECT_GT(mosaic.loops(), 1);
  EXPECT_LT(ErrorOf(mosaic, poses), 0.15);
}

TEST(MosaicTest, NeedsNoCameraForAPlane) {
  const std::vector<Pose> poses = TwoLanes();
  EXPECT_LT(ErrorOf(MosaicOf({}, poses), poses), 0.15);
}

TEST(MosaicTest, LoopsMakeItBetterThanAChain) {
  MosaicOptions chain = WithCamera();
  chain.loops = false;
  const std::vector<Pose> poses = TwoLanes();
  const Mosaic mosaic = MosaicOf(chain, poses);
  EXPECT_EQ(mosaic.loops(), 0);
  EXPECT_GT(ErrorOf(mosaic, poses), 1.5 * ErrorOf(MosaicOf(WithCamera(), poses), poses));
}

TEST(MosaicTest, TheSameBitsOnAnyNumberOfThreads) {
  std::vector<Pose> poses = TwoLanes();
  poses.resize(8);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const MosaicPicture one = MosaicOf(WithCamera(), poses).Picture();
  cv::setNumThreads(4);
  const MosaicPicture four = MosaicOf(WithCamera(), poses).Picture();
  cv::setNumThreads(threads);
  ASSERT_EQ(one.image.size(), four.image.size());
  EXPECT_EQ(cv::norm(one.image, four.image, cv::NORM_INF), 0);
}

TEST(MosaicTest, PosesLayItOutByTheGround) {
  RandomStream random(3, "test");
  const std::vector<Pose> poses = TwoLanes();
  MosaicOptions options = WithCamera();
  options.pose_sigma_m = 0.1, options.pose_sigma_deg = 0.3;
  Mosaic mosaic(options);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Pose known = poses[i];
    known.p += 0.1 * Vector3d(random.Normal(), random.Normal(), random.Normal());
    mosaic.Add(Ground().Draw(poses[i]), 0.1 * static_cast<double>(i), known);
  }
  mosaic.Adjust();
  const auto ground = mosaic.GroundFromSurface();
  ASSERT_TRUE(ground);
  double squares = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector2d middle(159.5, 119.5);
    const Vector2d is = Transfer(DrawnGround::GroundFromImage(poses[i]), middle),
                   placed = Transfer(*ground, *mosaic.PlaceOf(static_cast<int>(i), middle));
    squares += (is - placed).squaredNorm() / static_cast<double>(poses.size());
  }
  EXPECT_LT(std::sqrt(squares), 0.08);  // m; a single pose is off by 0.14 m
}

TEST(MosaicTest, WithoutPosesThereIsNoGround) {
  EXPECT_FALSE(MosaicOf(WithCamera(), {TwoLanes()[0]}).GroundFromSurface());
}

TEST(MosaicTest, OfOneImageWithoutACameraItIsThatImage) {
  const cv::Mat image = Ground().Draw(TwoLanes()[0]);
  MosaicOptions options;
  Mosaic mosaic(options);
  mosaic.Add(image, 0);
  const cv::Mat picture = mosaic.Picture().image;
  ASSERT_EQ(picture.size(), image.size());
  EXPECT_LE(cv::norm(picture, image, cv::NORM_INF), 1);
}

TEST(MosaicTest, APictureShowsTheGroundAsItIs) {
  const std::vector<Pose> poses = TwoLanes();
  const Mosaic mosaic = MosaicOf(WithCamera(), {poses.begin(), poses.begin() + 6});
  const MosaicPicture picture = mosaic.Picture();
  // By the first image, in whose frame it is.
  const Matrix3d ground = DrawnGround::GroundFromImage(poses[0]);
  const Projection& projection = mosaic.projection();
  double difference = 0;
  int compared = 0;
  for (int y = 20; y < picture.image.rows - 20; y += 5)
    for (int x = 20; x < picture.image.cols - 20; x += 5) {
      if (!picture.shown.at<std::uint8_t>(y, x)) continue;
      const auto uv =
          projection.ToImage(mosaic.M_WC(0)->inverse(), picture.origin + picture.scale * Vector2d(x, y));
      const Vector2d N = Transfer(ground, *uv);
      const cv::Point at(cvRound(N.y() / DrawnGround::kPixel_m + Ground().picture.cols / 2.0),
                         cvRound(-N.x() / DrawnGround::kPixel_m + Ground().picture.rows / 2.0));
      difference += std::abs(picture.image.at<std::uint8_t>(y, x) - Ground().picture.at<std::uint8_t>(at));
      ++compared;
    }
  EXPECT_GT(compared, 3000);
  EXPECT_LT(difference / compared, 8);  // grey levels; of a picture whose deviation is some 50
}

TEST(MosaicTest, SaysWhatItCannotPlace) {
  Mosaic mosaic(WithCamera());
  const cv::Mat blank(240, 320, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(mosaic.Add(blank, 0).state, MosaicState::kNoTexture);
  EXPECT_EQ(mosaic.Add({}, 0).state, MosaicState::kUnreadable);
  EXPECT_EQ(mosaic.Picture().image.empty(), true);
  EXPECT_EQ(mosaic.Add(Ground().Draw(DrawnGround::Above(0, 0, 10)), 1).state, MosaicState::kFirst);
  EXPECT_EQ(mosaic.Add(blank, 2).state, MosaicState::kNoTexture);
  EXPECT_EQ(mosaic.Add(cv::Mat(100, 100, CV_8UC1, cv::Scalar(0)), 3).state, MosaicState::kOtherSize);
  EXPECT_EQ(mosaic.Add(cv::Mat(240, 320, CV_8UC3, cv::Scalar(0)), 4).state, MosaicState::kOtherSize);
  EXPECT_EQ(mosaic.Add(DrawnGround(9).Draw(DrawnGround::Above(0, 0, 10)), 5).state, MosaicState::kLost);
  EXPECT_FALSE(mosaic.M_WC(6));
  EXPECT_EQ(mosaic.Add(Ground().Draw(DrawnGround::Above(0.5, 0, 10)), 6).state, MosaicState::kFound);
  EXPECT_EQ(mosaic.images(), 8);
}

TEST(MosaicTest, AJumpIsFoundByFeatures) {
  Mosaic mosaic(WithCamera());
  mosaic.Add(Ground().Draw(DrawnGround::Above(0, 0, 10)), 0);
  const Pose far = DrawnGround::Above(2.5, 2, 10, 40);  // 128 px, and turned
  const MosaicStep step = mosaic.Add(Ground().Draw(far), 1);
  EXPECT_EQ(step.state, MosaicState::kFound);
  EXPECT_GT(step.agreed, 15);
}

TEST(MosaicTest, MemoryIsBounded) {
  MosaicOptions options = WithCamera();
  options.most_bytes = 4'000'000;
  const std::int64_t most = Mosaic::MostKept(options, {320, 240}, 1);
  EXPECT_EQ(most, 2'000'000 / (2 * 320 * 240));
  Mosaic mosaic(options);
  int full = 0;
  for (int i = 0; i < 40; ++i) {
    full += mosaic.Add(Ground().Draw(DrawnGround::Above(-9 + 0.9 * (i % 20), i / 20 * 4, 10)), i).state ==
            MosaicState::kFull;
    EXPECT_LE(static_cast<std::int64_t>(mosaic.kept().size()), most);
    EXPECT_LE(mosaic.bytes(), options.most_bytes + 4 * 256 * 256 * 8);
  }
  EXPECT_GT(full, 0);
}

TEST(MosaicTest, ImagesBetweenKeyframesLeaveRoomForTheNextOne) {
  MosaicOptions options = WithCamera();
  options.most_bytes = 2'000'000;
  EXPECT_EQ(Mosaic::MostKept(options, {320, 240}, 1), 6);
  Mosaic mosaic(options);
  for (int i = 0; i < 20; ++i)
    EXPECT_TRUE(IsPlaced(mosaic.Add(Ground().Draw(DrawnGround::Above(0, 0.25 * i, 10)), i).state)) << i;
  EXPECT_GT(mosaic.keyframes(), 1);
  mosaic.Adjust();
  EXPECT_LE(mosaic.kept().size(), 6u);
}

TEST(MosaicTest, RefusesWhatCannotBe) {
  MosaicOptions rotation;
  rotation.model = MosaicModel::kRotation;
  rotation.surface = Surface::kSphere;
  EXPECT_THROW(Mosaic{rotation}, std::invalid_argument);
  MosaicOptions plane;
  plane.surface = Surface::kSphere;
  EXPECT_THROW(Mosaic{plane}, std::invalid_argument);
}

// A camera that turns before a wall: the same images, since a wall far away is a plane.
TEST(MosaicTest, RotationsAreFound) {
  MosaicOptions options = WithCamera();
  options.model = MosaicModel::kRotation;
  options.surface = Surface::kSphere;
  Mosaic mosaic(options);
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i) {
    poses.push_back(DrawnGround::Above(0, 0, 12, 3.0 * i, -20 + 4.0 * i, 10 * std::sin(0.5 * i)));
    EXPECT_TRUE(IsPlaced(mosaic.Add(Ground().Draw(poses.back()), i).state)) << i;
  }
  mosaic.Adjust();
  const Matrix3d R_WN = *mosaic.M_WC(0) * poses[0].R.toRotationMatrix().transpose();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Matrix3d off =
        *mosaic.M_WC(static_cast<int>(i)) * (R_WN * poses[i].R.toRotationMatrix()).transpose();
    EXPECT_LT(Degrees(LogRotation(Eigen::Quaterniond(off)).norm()), 0.03) << i;
  }
}

TEST(MosaicSeriesTest, ACutBeginsANewMosaic) {
  MosaicSeries series(WithCamera());
  const DrawnGround other(7);
  std::vector<bool> cuts;
  for (int i = 0; i < 20; ++i)
    cuts.push_back(
        series.Add((i < 8 ? Ground() : other).Draw(DrawnGround::Above(0.3 * i, 0, 10)), 0.1 * i).cause ==
        MosaicSeries::Cause::kCut);
  series.Finish();
  EXPECT_EQ(series.mosaics(), 2);
  EXPECT_EQ(std::count(cuts.begin(), cuts.end(), true), 1);
  EXPECT_TRUE(cuts[8 + MosaicSeries::kCut - 1]);
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(series.places()[static_cast<std::size_t>(i)].mosaic, i < 8 ? 0 : 1) << i;
  EXPECT_EQ(series.mosaic(1).images(), 12);
}

TEST(MosaicSeriesTest, ImagesThatAgreeWithNoneBetweenTwoMosaicsAreALossAndNoCut) {
  MosaicSeries series(WithCamera());
  const DrawnGround other(7);
  std::vector<MosaicSeries::Step> begun;
  for (int i = 0; i < 18; ++i) {
    const DrawnGround strange(static_cast<std::uint64_t>(30 + i));
    const DrawnGround& ground = i < 6 ? Ground() : i < 9 ? strange : other;
    const auto step = series.Add(ground.Draw(DrawnGround::Above(0.3 * i, 0, 10)), 0.1 * i);
    if (step.cause != MosaicSeries::Cause::kNone) begun.push_back(step);
  }
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_EQ(begun[0].cause, MosaicSeries::Cause::kLost);
  EXPECT_EQ(begun[0].lost, 3);
}

TEST(MosaicSeriesTest, AnImageThatCannotBeReadBeginsNothing) {
  MosaicSeries series(WithCamera());
  for (int i = 0; i < 12; ++i)
    series.Add(i == 5 ? cv::Mat() : Ground().Draw(DrawnGround::Above(0.2 * i, 0, 10)), 0.1 * i);
  series.Finish();
  EXPECT_EQ(series.mosaics(), 1);
  EXPECT_EQ(series.places()[5].step.state, MosaicState::kUnreadable);
  EXPECT_EQ(series.places()[6].step.state, MosaicState::kFollowed);
}

TEST(MosaicSeriesTest, AFewBadImagesAreNoCut) {
  MosaicSeries series(WithCamera());
  for (int i = 0; i < 12; ++i) {
    const bool bad = i == 5 || i == 6;
    series.Add((bad ? DrawnGround(static_cast<std::uint64_t>(20 + i)) : Ground())
                   .Draw(DrawnGround::Above(0.2 * i, 0, 10)),
               0.1 * i);
  }
  series.Finish();
  EXPECT_EQ(series.mosaics(), 1);
  EXPECT_EQ(series.places()[5].step.state, MosaicState::kLost);
  EXPECT_TRUE(IsPlaced(series.places()[7].step.state));
}

TEST(MosaicSeriesTest, ImagesOfAnotherSizeAreAnother) {
  MosaicSeries series{MosaicOptions{}};
  for (int i = 0; i < 14; ++i) {
    cv::Mat image = Ground().Draw(DrawnGround::Above(0.2 * i, 0, 10));
    if (i >= 6) image = image(cv::Rect(20, 20, 280, 200));
    const auto cause = series.Add(image, 0.1 * i).cause;
    EXPECT_EQ(cause == MosaicSeries::Cause::kResized, i == 6 + MosaicSeries::kCut - 1) << i;
  }
  series.Finish();
  EXPECT_EQ(series.mosaics(), 2);
  EXPECT_EQ(series.mosaic(1).projection().image_size(), cv::Size(280, 200));
}

// Otherwise each image for which there is no room would be a mosaic of its own.
TEST(MosaicSeriesTest, WhereMemoryIsUsedUpNoOtherMosaicBegins) {
  MosaicOptions options = WithCamera();
  options.most_bytes = 1'500'000;
  MosaicSeries series(options);
  int full = 0;
  for (int i = 0; i < 24; ++i) {
    const auto step = series.Add(Ground().Draw(DrawnGround::Above(-10 + 0.9 * i, 0, 10)), i);
    full += step.step.state == MosaicState::kFull;
    EXPECT_EQ(step.cause, MosaicSeries::Cause::kNone) << i;
  }
  series.Finish();
  EXPECT_GT(full, 8);
  EXPECT_EQ(series.mosaics(), 1);
  EXPECT_EQ(series.places().back().step.state, MosaicState::kFull);
}

}  // namespace
}  // namespace kestrel::vision
