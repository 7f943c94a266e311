// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/visual_compass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/diagnostics.h"
#include "tests/vision/horizon/skyline_photographer.h"
#include "vision/camera/calibration_file.h"
#include "vision/horizon/baseline/skyline_baseline.h"
#include "vision/horizon/horizon_attitude.h"

namespace kestrel::vision {
namespace {

CameraModel TheMirror() {
  Mistakes mistakes;
  return LoadCamera(std::string(KESTREL_SOURCE_DIR) + "/models/cameras/hyperbolic_mirror.yaml", mistakes);
}
const SkylinePhotographer& Photographer() {
  static const SkylinePhotographer photographer(TheMirror());
  return photographer;
}
PaintedWorld Hills() {
  PaintedWorld world;
  world.hills = [](double a) {
    return Radians(1.5) *
           (1.2 + std::sin(3 * a) * std::cos(a) + 0.5 * std::sin(11 * a + 1) + 0.3 * std::sin(29 * a));
  };
  return world;
}

TEST(VisualCompass, PureTurnsAreMeasuredToATenthOfADegreeAtAnyTilt) {
  VisualCompass compass(TheMirror(), LooksDown(), {}, {});
  const double start_deg = 20;
  double worst = 0;
  int k = 0;
  for (const double turn_deg : {0.0, 3.3, 41.7, 100.1, 181.2, 260.6, 359.4}) {
    const TaitBryan attitude{Radians(start_deg + turn_deg), Radians(12.0 * std::sin(2.0 * k)),
                             Radians(15.0 * std::sin(5.0 * k))};
    const Eigen::Matrix3d R_NC = RotationFromTaitBryan(attitude) * LooksDown();
    const cv::Mat image = Photographer().Paint(Hills(), R_NC, k++);
    const auto result = compass.Turn(image, Eigen::Vector3d(R_NC.transpose() * Eigen::Vector3d::UnitZ()));
    const auto* heading = std::get_if<CompassHeading>(&result);
    ASSERT_TRUE(heading) << turn_deg << ": " << NameOf(std::get<NoHeading>(result));
    worst = std::max(worst, std::abs(Degrees(WrapAngle(heading->turned - Radians(turn_deg)))));
  }
  EXPECT_LT(worst, 0.1);
}

TEST(VisualCompass, APinholeMeasuresTurnsWithinItsViewAsWellAsItSays) {
  const Pinhole camera{640, 480, 420, 420, 319.5, 239.5};
  const SkylinePhotographer photographer(camera);
  double squares_deg2 = 0, squares_by_variance = 0;
  int count = 0;
  for (const double start_deg : {0.0, 7.3, 14.9, 22.2, 31.6, 40.1}) {
    VisualCompass compass(camera, LooksForward(), {}, {});
    for (const double turn_deg : {0.0, 4.0, 11.0, 19.0}) {
      const Eigen::Matrix3d R_NC =
          RotationFromTaitBryan({Radians(start_deg + turn_deg), 0.05, -0.1}) * LooksForward();
      const auto result =
          compass.Turn(photographer.Paint(Hills(), R_NC, static_cast<int>(100 * start_deg + turn_deg)),
                       Eigen::Vector3d(R_NC.transpose() * Eigen::Vector3d::UnitZ()));
      const auto* heading = std::get_if<CompassHeading>(&result);
      ASSERT_TRUE(heading) << turn_deg << ": " << NameOf(std::get<NoHeading>(result));
      if (turn_deg == 0) continue;  // the first image, from which it counts
      const double error = heading->turned - Radians(turn_deg);
      squares_deg2 += Degrees(Degrees(error * error));
      squares_by_variance += error * error / heading->variance;
      ++count;
    }
  }
  ASSERT_EQ(count, 18);
  EXPECT_LT(std::sqrt(squares_deg2 / count), 0.3);
  EXPECT_LT(squares_by_variance / count, 1.5);
}

TEST(HorizonAttitude, WithoutASkylineTheExpectedDownStillGivesAHeading) {
  SkylineOptions none_is_good_enough;  // once "down" is expected
  none_is_good_enough.min_agreement_expected = 2;
  HorizonAttitude horizon(TheMirror(), LooksDown(), {}, none_is_good_enough, {});
  const Eigen::Matrix3d R_NC = LooksDown(), R_NC_later = RotationFromTaitBryan({0.2, 0, 0}) * LooksDown();
  ASSERT_TRUE(horizon.Measure(Photographer().Paint(Hills(), R_NC, 1)).attitude);
  HorizonAttitude::Expected expected;
  expected.down_B = Eigen::Vector3d::UnitZ();
  expected.down_sigma = Radians(1);
  const auto said = horizon.Measure(Photographer().Paint(Hills(), R_NC_later, 2), expected);
  ASSERT_FALSE(said.attitude);
  const auto* heading = std::get_if<CompassHeading>(&said.compass);
  ASSERT_TRUE(heading);
  EXPECT_NEAR(Degrees(heading->turned), Degrees(0.2), 0.15);
}

TEST(VisualCompass, SeveralTurnsAreCountedAndTheErrorDoesNotGrow) {
  VisualCompass compass(TheMirror(), LooksDown(), {}, {});
  for (int k = 0; k <= 18; ++k) {
    const double turn = Radians(50.0 * k);
    const Eigen::Matrix3d R_NC = RotationFromTaitBryan({turn, 0, 0}) * LooksDown();
    const auto result =
        compass.Turn(Photographer().Paint(Hills(), R_NC, k), Eigen::Vector3d(Eigen::Vector3d::UnitZ()));
    const auto* heading = std::get_if<CompassHeading>(&result);
    ASSERT_TRUE(heading) << k;
    EXPECT_NEAR(Degrees(heading->turned), 50.0 * k, 0.15) << k;
  }
  EXPECT_EQ(compass.keyframes(), 1);
}

TEST(VisualCompass, WithoutAVerticalOrAnythingKnownItSaysSo) {
  VisualCompass compass(TheMirror(), LooksDown(), {}, {});
  const Eigen::Matrix3d R_NC = LooksDown();
  const Eigen::Vector3d down = R_NC.transpose() * Eigen::Vector3d::UnitZ();
  const cv::Mat image = Photographer().Paint(Hills(), R_NC, 1);
  EXPECT_EQ(std::get<NoHeading>(compass.Turn(image, {})), NoHeading::kNoVertical);
  EXPECT_TRUE(std::holds_alternative<CompassHeading>(compass.Turn(image, down)));
  cv::Mat elsewhere(image.size(), CV_8UC3);
  cv::RNG rng(4);
  rng.fill(elsewhere, cv::RNG::UNIFORM, 0, 255);
  EXPECT_EQ(std::get<NoHeading>(compass.Turn(elsewhere, down)), NoHeading::kNothingMatches);
}

TEST(CompassBaseline, AddsUpTurnsOnTheSpot) {
  // The mirror looks down, its top forward: the nose is at -90 degrees in the image and azimuth runs
  // clockwise.
  CompassBaseline compass(TheMirror(), {{319.5, 239.5}, 110, 150, -M_PI / 2, 1});
  double turned = 0;
  for (int k = 0; k <= 8; ++k)
    turned = compass.Turn(
        Photographer().Paint(Hills(), RotationFromTaitBryan({Radians(4.0 * k), 0, 0}) * LooksDown(), k));
  EXPECT_NEAR(Degrees(turned), 32, 2);
}

}  // namespace
}  // namespace kestrel::vision
