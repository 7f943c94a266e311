// SPDX-License-Identifier: Apache-2.0
#include "sim/instrument/kalibr_imu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kestrel::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kInput[] = R"(#Accelerometers
accelerometer_noise_density: 1.86e-03   #Noise density (continuous-time)
accelerometer_random_walk:   4.33e-04   #Bias random walk

#Gyroscopes
gyroscope_noise_density:     1.87e-04   #Noise density (continuous-time)
gyroscope_random_walk:       2.66e-05   #Bias random walk

rostopic:                    /imu0      #the IMU ROS topic
update_rate:                 250.0      #Hz (for discretization of the values above)
)";

std::vector<std::string> MistakesOf(const std::string& text, ImuParameters& imu) {
  Mistakes mistakes;
  ReadKalibrImu(ParseConfig(text, "imu.yaml", {}, mistakes), imu, mistakes);
  return mistakes.Texts();
}

void ExpectTheNumbers(const ImuParameters& imu) {
  EXPECT_EQ(imu.accelerometer_noise_density, 1.86e-3);
  EXPECT_EQ(imu.accelerometer_random_walk, 4.33e-4);
  EXPECT_EQ(imu.gyroscope_noise_density, 1.87e-4);
  EXPECT_EQ(imu.gyroscope_random_walk, 2.66e-5);
  EXPECT_EQ(imu.rate_hz, 250);
}

TEST(KalibrImu, IsReadAsItIsGivenToKalibr) {
  ImuParameters imu;
  EXPECT_THAT(MistakesOf(kInput, imu), IsEmpty());
  ExpectTheNumbers(imu);
}

TEST(KalibrImu, IsReadAsKalibrWritesItsResults) {
  ImuParameters imu;
  EXPECT_THAT(MistakesOf(R"(imu0:
  T_i_b:
  - [1.0, 0.0, 0.0, 0.0]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  accelerometer_noise_density: 0.00186
  accelerometer_random_walk: 0.000433
  gyroscope_noise_density: 0.000187
  gyroscope_random_walk: 2.66e-05
  model: calibrated
  rostopic: /imu0
  time_offset: 0.0
  update_rate: 250.0
)",
                         imu),
              IsEmpty());
  ExpectTheNumbers(imu);
}

TEST(KalibrImu, EveryMistakeIsToldWithItsLine) {
  ImuParameters imu;
  EXPECT_THAT(
      MistakesOf("accelerometer_noise_density: -1\naccelerometer_random_walk: 4e-4\n"
                 "gyroscope_noise_density: fast\nupdate_rate: 200\n",
                 imu),
      ElementsAre(HasSubstr("imu.yaml:1: accelerometer_noise_density"),
                  HasSubstr("imu.yaml:3: gyroscope_noise_density"), HasSubstr("gyroscope_random_walk")));
}

}  // namespace
}  // namespace kestrel::sim
