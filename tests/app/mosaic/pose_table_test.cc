// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/pose_table.h"

#include <gmock/gmock.h>

#include <fstream>
#include <string>

#include "geometry/tait_bryan.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kHeader = "north_m,east_m,down_m,yaw_deg,pitch_deg,roll_deg\n";

class PoseTableTest : public InTemporaryFolder {
 protected:
  std::string Written(const std::string& text) const {
    const std::string file = (folder_ / "poses.csv").string();
    std::ofstream(file) << text;
    return file;
  }
  std::vector<std::optional<Pose>> Read(const std::string& text) const {
    Mistakes mistakes;
    auto poses = ReadPoseTable(Written(text), mistakes);
    mistakes.ThrowIfAny();
    return poses;
  }
  std::string Refusal(const std::string& text) const {
    try {
      Read(text);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }
};

TEST_F(PoseTableTest, ColumnsAreFoundByTheirNames) {
  const auto poses = Read("t_s,roll_deg,pitch_deg,yaw_deg,down_m,east_m,north_m\r\n0,1,2,90,-30,5,4\r\n");
  ASSERT_EQ(poses.size(), 1u);
  ASSERT_TRUE(poses[0]);
  EXPECT_EQ(poses[0]->p, Eigen::Vector3d(4, 5, -30));
  // Forward is east, three axes turned one after the other.
  const Eigen::Matrix3d turned = (Eigen::AngleAxisd(Radians(90), Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(Radians(2), Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(Radians(1), Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
  EXPECT_LT((poses[0]->R.toRotationMatrix() - turned).norm(), 1e-12);
}

TEST_F(PoseTableTest, ARowWithAnEmptyCellHasNoPose) {
  const auto poses = Read(std::string(kHeader) + "1,2,-3,0,0,0\n1,,-3,0,0,0\n2,2,-3,0,0,0\n");
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_TRUE(poses[0]);
  EXPECT_FALSE(poses[1]);
  ASSERT_TRUE(poses[2]);
  EXPECT_EQ(poses[2]->p.x(), 2);
}

// The estimate is of the time at which it is given; the image was exposed before.
TEST_F(PoseTableTest, TelemetryIsBroughtToTheTimesOfExposure) {
  const auto poses = Read(
      "t_s,exposure_t_s,estimate_x_m,estimate_y_m,estimate_z_m,estimate_yaw_deg,estimate_pitch_deg,"
      "estimate_roll_deg\n"
      "1.0,0.95,0,0,-10,0,0,0\n1.1,1.05,2,4,-12,20,0,0\n1.2,1.2,3,4,-12,20,0,0\n");
  ASSERT_EQ(poses.size(), 3u);
  ASSERT_TRUE(poses[0]) << "exposed before the first row, and less than rows are apart";
  EXPECT_LT((poses[0]->p - Eigen::Vector3d(-1, -2, -9)).norm(), 1e-9);
  EXPECT_LT(poses[0]->R.angularDistance(
                Eigen::Quaterniond(Eigen::AngleAxisd(Radians(-10), Eigen::Vector3d::UnitZ()))),
            1e-7);
  ASSERT_TRUE(poses[1]);
  EXPECT_LT((poses[1]->p - Eigen::Vector3d(1, 2, -11)).norm(), 1e-9);
  EXPECT_LT(poses[1]->R.angularDistance(
                Eigen::Quaterniond(Eigen::AngleAxisd(Radians(10), Eigen::Vector3d::UnitZ()))),
            1e-9);
  ASSERT_TRUE(poses[2]);
  EXPECT_LT((poses[2]->p - Eigen::Vector3d(3, 4, -12)).norm(), 1e-9);
}

TEST_F(PoseTableTest, AnExposureLongBeforeTheFirstRowHasNoPose) {
  const std::string columns =
      "t_s,exposure_t_s,estimate_x_m,estimate_y_m,estimate_z_m,estimate_yaw_deg,estimate_pitch_deg,"
      "estimate_roll_deg\n";
  const auto poses = Read(columns + "1.0,0.8,0,0,-10,0,0,0\n1.1,1.0,2,4,-12,20,0,0\n");
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_FALSE(poses[0]);
  ASSERT_TRUE(poses[1]);
  EXPECT_EQ(poses[1]->p, Eigen::Vector3d(0, 0, -10));
  EXPECT_FALSE(Read(columns + "1.0,0.9,0,0,-10,0,0,0\n")[0]) << "of one row nothing can be carried back";
}

TEST_F(PoseTableTest, EveryColumnThatIsMissingIsTold) {
  EXPECT_THAT(Refusal("north_m,east_m,yaw_deg\n1,2,3\n"),
              AllOf(HasSubstr("down_m"), HasSubstr("pitch_deg"), HasSubstr("roll_deg"),
                    HasSubstr("no such column"), HasSubstr("north_m,east_m,down_m")));
  EXPECT_THAT(Refusal(""), HasSubstr("no such column"));
  EXPECT_THAT(Refusal("exposure_t_s,estimate_x_m\n"), AllOf(HasSubstr("t_s"), HasSubstr("estimate_y_m")));
}

TEST_F(PoseTableTest, AMistakeHasItsLine) {
  EXPECT_THAT(Refusal(std::string(kHeader) + "1,2,-3,0,0,0\n1,2,-3,0,x7,0\n"),
              AllOf(HasSubstr("poses.csv:3"), HasSubstr("pitch_deg"), HasSubstr("'x7' is no number")));
  EXPECT_THAT(Refusal(std::string(kHeader) + "1,2,-3,0,0\n"),
              AllOf(HasSubstr("poses.csv:2"), HasSubstr("5 cells"), HasSubstr("6")));
  EXPECT_THAT(Refusal(std::string(kHeader) + "1,nan,-3,0,0,0\n"), HasSubstr("'nan' is no number"));
}

TEST_F(PoseTableTest, AFileThatIsNotThereIsAMistake) {
  Mistakes mistakes;
  EXPECT_TRUE(ReadPoseTable(folder_ / "none.csv", mistakes).empty());
  EXPECT_FALSE(mistakes.empty());
}

}  // namespace
}  // namespace kestrel::app
