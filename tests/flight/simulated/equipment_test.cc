// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/equipment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/yaml/yaml_fields.h"
#include "flight/simulated/scenario.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class Equipment : public InTemporaryFolder {
 protected:
  // The file of a hover that carries this.
  std::string With(const std::string& equipment) const {
    const std::filesystem::path file = folder_ / "equipped.yaml";
    std::ofstream(file) << "mission: hover\n" << equipment;
    return file.string();
  }
  LoadedScenario Loaded(const std::string& equipment, const std::vector<std::string>& overrides = {}) const {
    return LoadScenario(With(equipment), overrides, false);
  }
};

TEST_F(Equipment, IsNoneWhereNothingIsSaid) {
  const LoadedScenario loaded = Loaded("");
  EXPECT_TRUE(loaded.simulator.cameras.empty());
  EXPECT_FALSE(loaded.simulator.instruments.any());
}

TEST_F(Equipment, CamerasHaveTheClockThatTriggersThem) {
  const LoadedScenario loaded = Loaded(
      "image: {rate_hz: 25}\n"
      "cameras:\n"
      "  - {name: right, trigger: left}\n"
      "  - {name: left, trigger: front}\n"
      "  - {name: front, image: {rate_hz: 40}, phase_s: 0.01, drift_ppm: 20, camera: thesis_6mm_binned}\n"
      "  - {name: down, trigger: main}\n");
  const auto& cameras = loaded.simulator.cameras;
  ASSERT_EQ(cameras.size(), 4u);
  for (const std::size_t i : {0, 1, 2}) {
    EXPECT_EQ(cameras[i].image.rate_hz, 40);
    EXPECT_EQ(cameras[i].timing.phase_s, 0.01);
    EXPECT_EQ(cameras[i].timing.drift_ppm, 20);
  }
  EXPECT_EQ(cameras[3].image.rate_hz, 25);
  EXPECT_EQ(cameras[3].timing.phase_s, 0);
  EXPECT_EQ(vision::WidthPx(cameras[2].camera), 320);
}

TEST_F(Equipment, NamesThatDoNotTellTheCamerasApartAreRefused) {
  EXPECT_THAT([&] { Loaded("cameras:\n  - {name: left}\n  - {name: left}\n"); },
              ThrowsMessage<InputError>(
                  HasSubstr("equipped.yaml:4: cameras.1.name: 'left' is the name of an earlier one")));
  EXPECT_THAT([&] { Loaded("cameras:\n  - {name: main}\n"); },
              ThrowsMessage<InputError>(HasSubstr("equipped.yaml:3: cameras.0.name: 'main' cannot name")));
  EXPECT_THAT([&] { Loaded("cameras:\n  - {camera: thesis_6mm}\n"); },
              ThrowsMessage<InputError>(HasSubstr("cameras.0.name")));
}

TEST_F(Equipment, TriggersThatLeadToNoClockAreRefused) {
  EXPECT_THAT([&] { Loaded("cameras:\n  - {name: left, trigger: rigth}\n  - {name: right}\n"); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("equipped.yaml:3: cameras.0.trigger: there is no camera 'rigth'"),
                        HasSubstr("valid: free, main, right"))));
  EXPECT_THAT(
      [&] { Loaded("cameras:\n  - {name: left, trigger: right}\n  - {name: right, trigger: left}\n"); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("equipped.yaml:3: cameras.0.trigger: 'right' leads back"),
                                      HasSubstr("equipped.yaml:4: cameras.1.trigger"))));
  EXPECT_THAT([&] { Loaded("cameras:\n  - {name: left, trigger: left}\n"); },
              ThrowsMessage<InputError>(HasSubstr("cameras.0.trigger")));
  EXPECT_THAT(
      [&] {
        Loaded("cameras:\n  - {name: left, trigger: main, image: {rate_hz: 7}, phase_s: 1, drift_ppm: 3}\n");
      },
      ThrowsMessage<InputError>(
          AllOf(HasSubstr("cameras.0.image: rate_hz is 7, but it is triggered by 'main'"),
                HasSubstr("cameras.0.phase_s: 1,"), HasSubstr("cameras.0.drift_ppm: 3,"))));
}

TEST_F(Equipment, MistakesInACameraNameWhichItIs) {
  EXPECT_THAT(
      [&] {
        Loaded(
            "cameras:\n  - {name: a}\n  - {name: b, image: {latency_s: 0.001, exposure: {time_s: 0.02}}}\n");
      },
      ThrowsMessage<InputError>(HasSubstr("equipped.yaml:4: cameras.1.image.latency_s")));
  EXPECT_THAT([&] { Loaded("cameras:\n  - {name: a, camera: thesis_7mm}\n"); },
              ThrowsMessage<InputError>(
                  HasSubstr("equipped.yaml:3: cameras.0.camera: there is no camera 'thesis_7mm'")));
}

constexpr char kImu[] =
    "accelerometer_noise_density: 0.002\naccelerometer_random_walk: 0.0004\n"
    "gyroscope_noise_density: 0.0002\ngyroscope_random_walk: 0.00003\nupdate_rate: 250\n";

TEST_F(Equipment, AnImuTakesItsNumbersFromKalibrsFileUnderTheScenariosOwn) {
  std::ofstream(folder_ / "imu.yaml") << kImu;
  const auto imu = Loaded("instruments: {imu: {file: imu.yaml, gyroscope_random_walk: 0.00001}}\n",
                          {"instruments.imu.rate_hz=500"})
                       .simulator.instruments.imu;
  ASSERT_TRUE(imu);
  EXPECT_EQ(imu->accelerometer_noise_density, 0.002);
  EXPECT_EQ(imu->gyroscope_random_walk, 0.00001);
  EXPECT_EQ(imu->rate_hz, 500);
  EXPECT_EQ(imu->file, (folder_ / "imu.yaml").string());  // so that a record of it finds it
}

TEST_F(Equipment, AsItIsRecordedItIsReadBack) {
  std::ofstream(folder_ / "imu.yaml") << kImu;
  const LoadedScenario given = Loaded(
      "image: {rate_hz: 30}\n"
      "instruments: {imu: {file: imu.yaml}, rangefinder: {max_m: 9}}\n"
      "cameras:\n"
      "  - {name: left, trigger: main, mount: {position_m: [0.1, -0.1, 0]}}\n"
      "  - {name: tail, image: {rate_hz: 15}, phase_s: 0.01}\n");
  const std::string recorded = ToYaml(given.scenario);
  std::ofstream(folder_ / "recorded.yaml") << recorded;
  const LoadedScenario again = LoadScenario((folder_ / "recorded.yaml").string(), {}, false);
  EXPECT_EQ(ToYaml(again.scenario), recorded);
  EXPECT_EQ(again.simulator.instruments.imu->rate_hz, 250);
  EXPECT_EQ(again.simulator.cameras.at(0).image.rate_hz, 30);
  EXPECT_EQ(again.simulator.cameras.at(1).timing.phase_s, 0.01);
}

TEST_F(Equipment, AFileOfAnImuThatIsNotThereOrNotWholeIsRefused) {
  EXPECT_THAT([&] { Loaded("instruments: {imu: {file: none.yaml}}\n"); },
              ThrowsMessage<InputError>(HasSubstr("equipped.yaml:2: instruments.imu.file")));
  std::ofstream(folder_ / "imu.yaml") << "update_rate: 250\n";
  EXPECT_THAT([&] { Loaded("instruments: {imu: {file: imu.yaml}}\n"); },
              ThrowsMessage<InputError>(HasSubstr("accelerometer_noise_density")));
}

TEST_F(Equipment, ARangefinderWithoutABeamOrARangeIsRefused) {
  EXPECT_THAT([&] { Loaded("instruments:\n  rangefinder: {direction: [0, 0, 0], min_m: 5, max_m: 4}\n"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("instruments.rangefinder.direction: has no length"),
                                              HasSubstr("instruments.rangefinder.max_m: 4 is not above"))));
}

}  // namespace
}  // namespace kestrel::flight
