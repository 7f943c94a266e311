// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "flight/simulated/scenario.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class MountNote : public InTemporaryFolder {
 protected:
  std::vector<std::string> NotesWith(const std::string& place) const {
    std::ofstream(folder_ / "camchain.yaml")
        << "cam0:\n  camera_model: pinhole\n  distortion_coeffs: []\n  distortion_model: none\n"
           "  intrinsics: [810, 810, 319.5, 239.5]\n  resolution: [640, 480]\n"
        << place;
    return LoadScenario("pose", {"camera=" + (folder_ / "camchain.yaml").string()}, false).notes;
  }
};

// A camera that looks down with the top of its image forward, on an IMU with axes forward, left, up.
TEST_F(MountNote, TellsTheMountThatTheCamerasFileMeans) {
  const std::string place =
      "  T_imu_cam: [[0, -1, 0, 0.1], [-1, 0, 0, -0.02], [0, 0, -1, -0.05], [0, 0, 0, 1]]\n";
  EXPECT_THAT(NotesWith(place),
              Contains(HasSubstr("mount: {position_m: [0.100, 0.020, 0.050], yaw_deg: 0.00, pitch_deg: 0.00, "
                                 "roll_deg: 0.00} with forward, left, up")));
  EXPECT_THAT(NotesWith(""), Not(Contains(HasSubstr("IMU"))));
  EXPECT_THAT(NotesWith("  T_imu_cam: [1, 2]\n"), Contains(HasSubstr("is no rigid motion")));
}

}  // namespace
}  // namespace kestrel::flight
