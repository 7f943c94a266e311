// SPDX-License-Identifier: Apache-2.0
#include "control/link/afcs_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "base/yaml/yaml_fields.h"

namespace kestrel::control::wire {
namespace {

using ::testing::HasSubstr;

AfcsTeleopAxes Trimmed(bool alt_up) {
  return {{0.20, 0.05}, {-0.10, 0.02}, {0.30, 0.10}, {0.04, 0.01}, alt_up};
}

TEST(AfcsTeleop, ZeroVelocityIsCommandedAsTheOffset) {
  const AfcsTeleop teleop = TeleopFor(VelocitySetpoint{}, Trimmed(true));
  EXPECT_EQ(teleop, (AfcsTeleop{0.20, -0.10, 0.30, 0.04}));
}

TEST(AfcsTeleop, AVerySmallCommandMovesTheAircraftBackwards) {
  EXPECT_NEAR(VelocityOf({.fore = 0.01}, {.fore = {0.20, 0.05}, .side = {}, .alt = {}, .hdg = {}}).v_H.x(),
              -0.14, 1e-15);
}

TEST(AfcsTeleop, NothingMovesWithinTheDeadZone) {
  const AfcsTeleopAxes axes{.fore = {0.20, 0.05}, .side = {}, .alt = {}, .hdg = {}};
  EXPECT_EQ(VelocityOf({.fore = 0.16}, axes).v_H.x(), 0);
  EXPECT_EQ(VelocityOf({.fore = 0.24}, axes).v_H.x(), 0);
  EXPECT_NEAR(VelocityOf({.fore = 0.26}, axes).v_H.x(), 0.01, 1e-15);
}

TEST(AfcsTeleop, WithoutTrimTheCommandIsTheVelocityAndAltIsUpOrDownAsSaid) {
  const VelocitySetpoint wanted{{1, 2, 3}, 4};
  EXPECT_EQ(TeleopFor(wanted, {}), (AfcsTeleop{1, 2, -3, 4}));
  AfcsTeleopAxes down;
  down.alt_up = false;
  EXPECT_EQ(TeleopFor(wanted, down), (AfcsTeleop{1, 2, 3, 4}));
}

TEST(AfcsTeleop, WhatIsCommandedForAVelocityIsObeyedAsIt) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const bool alt_up : {true, false}) {
    for (int i = 0; i < 1000; ++i) {
      const VelocitySetpoint wanted{{number(random), number(random), number(random)}, number(random)};
      const VelocitySetpoint obeyed = VelocityOf(TeleopFor(wanted, Trimmed(alt_up)), Trimmed(alt_up));
      ASSERT_LT((obeyed.v_H - wanted.v_H).norm(), 1e-14);
      ASSERT_NEAR(obeyed.yaw_rate, wanted.yaw_rate, 1e-14);
    }
  }
}

class AfcsProfileFile : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(::testing::TempDir()) /
            ("afcs_profile_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) +
             ".yaml");
  }
  void TearDown() override { std::filesystem::remove(file_); }
  AfcsSettings Written(const AfcsProfile& profile) {
    std::ofstream(file_) << ToYaml(profile);
    AfcsSettings settings;
    settings.profile = file_.string();
    return settings;
  }
  std::filesystem::path file_;
};

TEST_F(AfcsProfileFile, IsTakenInPlaceOfTheBuiltInOne) {
  AfcsProfile profile = ThesisAfcsProfile();
  profile.header_byte_order = "little";
  const AfcsProfile read = ProfileOf(Written(profile));
  EXPECT_EQ(read.header_byte_order, "little");
  EXPECT_EQ(ToYaml(read), ToYaml(profile));
}

TEST_F(AfcsProfileFile, WithMistakesIsRefusedWithAllOfThem) {
  AfcsProfile profile = ThesisAfcsProfile();
  profile.messages[0].id = profile.messages[1].id;
  profile.messages[3].fields[0].name = "phy";
  try {
    ProfileOf(Written(profile));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("has the id of another"));
    EXPECT_THAT(error.what(), HasSubstr("state.phy"));
  }
}

TEST_F(AfcsProfileFile, ThatIsNotThereIsRefusedByName) {
  AfcsSettings settings;
  settings.profile = "/nowhere/afcs.yaml";
  try {
    ProfileOf(settings);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/afcs.yaml"));
  }
}

TEST(AfcsTimes, AreSecondsToTheMicrosecond) {
  EXPECT_EQ(AfcsTimeOf(12.345678), (AfcsTime{12, 345678}));
  EXPECT_EQ(AfcsTimeOf(1.9999999), (AfcsTime{2, 0}));
  EXPECT_EQ(AfcsTimeOf(-3), (AfcsTime{}));
  EXPECT_EQ(AfcsTimeOf(std::nan("")), (AfcsTime{}));
  EXPECT_NEAR(Seconds({12, 345678}), 12.345678, 1e-12);
}

}  // namespace
}  // namespace kestrel::control::wire
