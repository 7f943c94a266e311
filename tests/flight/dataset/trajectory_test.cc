// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/trajectory/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "flight/dataset/trajectory/pose_file.h"
#include "geometry/tait_bryan.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000'000;

Trajectory Curved(bool along) {
  return Trajectory({0, kSecond, 3 * kSecond, 4 * kSecond}, {{0, 0, -5}, {4, 1, -6}, {6, 9, -4}, {3, 12, -5}},
                    {{0.2, 0, 0}, {0.9, 0.1, -0.2}, {2, -0.1, 0.3}, {2.4, 0, 0.1}}, along);
}

// By differences of what the trajectory itself gives, of half a step to both sides.
void ExpectItsOwnDerivatives(const Trajectory& trajectory, double tolerance) {
  constexpr std::int64_t kHalf = 50'000;
  for (const double t_s : {0.3, 0.9, 1.7, 2.4, 3.3}) {
    const auto t = static_cast<std::int64_t>(t_s * 1e9);
    const Motion before = trajectory.At(t - kHalf), now = trajectory.At(t), after = trajectory.At(t + kHalf);
    const double h = 2e-9 * kHalf;
    EXPECT_LT(((after.X_NB.p - before.X_NB.p) / h - now.v_N).norm(), tolerance);
    EXPECT_LT(((after.v_N - before.v_N) / h - now.a_N).norm(), tolerance);
    EXPECT_LT((LogRotation(before.X_NB.R.conjugate() * after.X_NB.R) / h - now.w_B).norm(), tolerance);
  }
}

TEST(Trajectory, RatesAndAccelerationsAreTheDerivativesOfThePose) {
  ExpectItsOwnDerivatives(Curved(false), 1e-5);
  ExpectItsOwnDerivatives(Curved(true), 1e-4);
}

TEST(Trajectory, LeadsThroughItsPlacesWithoutAJumpOfTheAcceleration) {
  const Trajectory trajectory = Curved(false);
  EXPECT_LT((trajectory.At(kSecond).X_NB.p - Eigen::Vector3d(4, 1, -6)).norm(), 1e-12);
  EXPECT_LT((trajectory.At(3 * kSecond).X_NB.p - Eigen::Vector3d(6, 9, -4)).norm(), 1e-12);
  EXPECT_NEAR(YawOf(trajectory.At(3 * kSecond).X_NB.R), 2, 1e-12);
  for (const std::int64_t knot : {kSecond, 3 * kSecond})
    EXPECT_LT((trajectory.At(knot - 1).a_N - trajectory.At(knot + 1).a_N).norm(), 1e-6);
}

TEST(Trajectory, LooksAlongTheWay) {
  const Motion motion = Curved(true).At(2 * kSecond);
  EXPECT_NEAR(YawOf(motion.X_NB.R), std::atan2(motion.v_N.y(), motion.v_N.x()), 1e-12);
}

TEST(Trajectory, AtRestTheAccelerometerSaysGravityAlone) {
  const Pose X_NB{HeadingRotation(1), {1, 2, -3}};
  const Trajectory still({0, kSecond}, std::vector<Pose>{X_NB, X_NB});
  EXPECT_LT((still.At(kSecond / 2).SpecificForce_B() - Eigen::Vector3d(0, 0, -9.80665)).norm(), 1e-9);
  EXPECT_LT(still.At(kSecond / 2).w_B.norm(), 1e-12);
}

TEST(Trajectory, BetweenPosesItTurnsEvenlyAboutOneAxis) {
  const Eigen::Vector3d turn(0.3, -0.2, 0.5);
  const Trajectory trajectory(
      {0, 2 * kSecond},
      std::vector<Pose>{{Eigen::Quaterniond::Identity(), {0, 0, -1}}, {ExpRotation(turn), {1, 0, -1}}});
  EXPECT_LT((trajectory.At(kSecond).w_B - turn / 2).norm(), 1e-12);
  EXPECT_LT(trajectory.At(kSecond).X_NB.R.angularDistance(ExpRotation(turn / 2)), 1e-12);
  EXPECT_LT(trajectory.At(2 * kSecond).X_NB.R.angularDistance(ExpRotation(turn)), 1e-12);
}

class TrajectoryFile : public InTemporaryFolder {
 protected:
  std::filesystem::path Written(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string Refused(const char* name, const std::string& text) const {
    const std::filesystem::path file = Written(name, text);
    try {
      IsPoseFile(file) ? LoadPoses(file, {}) : LoadWay(file);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
};

TEST_F(TrajectoryFile, OfTumIsOfTheCameraAndKeepsEachNanosecond) {
  const auto file = Written("poses.txt",
                            "# timestamp tx ty tz qx qy qz qw\n"
                            "1305031102.123456789 1 2 3 0 0 0 1\n"
                            "1305031102.5 1 2 4 0 0 0.70710678 0.70710678\n");
  const Pose X_BC{Eigen::Quaterniond::Identity(), {0.1, 0, 0}};
  const LoadedTrajectory loaded = LoadPoses(file, X_BC);
  EXPECT_EQ(loaded.stamps_ns, (std::vector<std::int64_t>{1305031102123456789, 1305031102500000000}));
  // The world's z is up and its y west.
  const Pose X_NC = loaded.trajectory.At(1305031102123456789).X_NB * X_BC;
  EXPECT_LT((X_NC.p - Eigen::Vector3d(1, -2, -3)).norm(), 1e-9);
  EXPECT_LT((X_NC.R * Eigen::Vector3d::UnitZ() - Eigen::Vector3d(0, 0, -1)).norm(), 1e-9);
}

TEST_F(TrajectoryFile, OfEurocIsOfTheBody) {
  const auto file = Written("poses.csv",
                            "#timestamp, p_RS_R_x [m]\n"
                            "1403636580838555648,4.6,-1.7,0.8,0.5,-0.5,0.5,-0.5,0.1,0.2,0.3,0,0,0,0,0,0\n"
                            "1403636580843555648,4.6,-1.7,0.9,0.5,-0.5,0.5,-0.5,0.1,0.2,0.3,0,0,0,0,0,0\n");
  const LoadedTrajectory loaded = LoadPoses(file, {});
  const Motion motion = loaded.trajectory.At(1403636580838555648);
  EXPECT_LT((motion.X_NB.p - Eigen::Vector3d(4.6, 1.7, -0.8)).norm(), 1e-9);
  EXPECT_NEAR(motion.v_N.z(), -20, 1e-9);  // 0.1 m up in 5 ms
}

TEST_F(TrajectoryFile, OfPosesTellsEveryMistakeWithItsLine) {
  EXPECT_THAT(Refused("bad.txt",
                      "1.0 0 0 1 0 0 0 1\n"
                      "1.0 0 0 1 0 0 0 1\n"
                      "0.5 0 0 1 0 0 0 1\n"
                      "2.0 nan 0 1 0 0 0 1\n"
                      "3.0 0 0 1 0 0 0 2\n"
                      "4.0 0 0 1\n"
                      "x 0 0 1 0 0 0 1\n"),
              AllOf(HasSubstr("bad.txt:2: the stamp 1.0 is not after that of line 1; valid: each stamp once"),
                    HasSubstr("bad.txt:3: the stamp 0.5 is not after that of line 1; valid: rising stamps"),
                    HasSubstr("bad.txt:4: 'nan' is not a finite number"),
                    HasSubstr("bad.txt:5: the quaternion has the length 2; valid: 1"),
                    HasSubstr("bad.txt:6: has 4 values"), HasSubstr("bad.txt:7: 'x' is no stamp")));
  EXPECT_THAT(Refused("long.csv", "0,0,0,1,1,0,0,0\n9000000000000000000,0,0,1,1,0,0,0\n"),
              HasSubstr("long.csv:2: is 9e+09 s after the first pose; valid: up to 36000 s"));
  EXPECT_THAT(Refused("one.csv", "0,0,0,1,1,0,0,0\n"), HasSubstr("holds 1 poses; valid: two or more"));
}

TEST_F(TrajectoryFile, OfAWayTellsEveryMistakeWithItsLine) {
  EXPECT_THAT(Refused("way.yaml",
                      "way:\n"
                      "  - {t_s: 0, position_m: [0, 0, 5]}\n"
                      "  - {t_s: 2, position_m: [0, 5, 5]}\n"
                      "  - {t_s: 2, position_m: [0, 9, 5]}\n"
                      "  - {t_s: 1, position_m: [0, 9, 5]}\n"),
              AllOf(HasSubstr("way.yaml:4: way[2].t_s: 2 is not after 2"),
                    HasSubstr("way.yaml:5: way[3].t_s: 1 is not after 2")));
  EXPECT_THAT(Refused("still.yaml",
                      "look: along\n"
                      "way:\n"
                      "  - {t_s: 0, position_m: [0, 0, 5]}\n"
                      "  - {t_s: 2, position_m: [0, 0, 9]}\n"),
              HasSubstr("still.yaml:4: look: along, but at 0.00 s the way does not move horizontally"));
}

}  // namespace
}  // namespace kestrel::flight
