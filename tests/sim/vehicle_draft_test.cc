// SPDX-License-Identifier: Apache-2.0
#include "sim/vehicle_draft.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/yaml/yaml_fields.h"
#include "sim/vehicle_file.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::sim {
namespace {

using testing::HasSubstr;

class VehicleDrafts : public InTemporaryFolder {
 protected:
  MultirotorParameters ReadBack(const VehicleDraft& draft) {
    Mistakes mistakes;
    const auto file = folder_ / "drafted.yaml";
    std::ofstream(file) << VehicleText(draft, mistakes);
    VehicleFile read;
    Read(LoadConfig(file, {}, mistakes), read, mistakes);
    EXPECT_THAT(mistakes.Texts(), testing::IsEmpty());
    return std::get<MultirotorParameters>(read.airframe);
  }
};

// The Pelican's inertia and coefficients are known from elsewhere: estimates that are far off would show.
TEST_F(VehicleDrafts, APelicanComesOutLikeThePelican) {
  VehicleDraft draft;
  draft.name = "like_the_pelican";
  draft.mass_kg = 1.3, draft.arm_m = 0.21, draft.layout = "plus", draft.thrust_to_weight = 2.2;
  draft.propeller_m = 0.256;
  const MultirotorParameters p = ReadBack(draft), pelican;
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(p.inertia_kg_m2[axis] / pelican.inertia_kg_m2[axis], 1, 0.25) << axis;
  EXPECT_NEAR(p.rotor.thrust_coefficient_n_s2 / pelican.rotor.thrust_coefficient_n_s2, 1, 0.4);
  EXPECT_NEAR(p.rotor.moment_coefficient_m / pelican.rotor.moment_coefficient_m, 1, 0.3);
  EXPECT_NEAR(p.rotor.max_speed_rad_s / pelican.rotor.max_speed_rad_s, 1, 0.2);
}

TEST_F(VehicleDrafts, EachLayoutCanFly) {
  int count = 0;
  for (const char* layout : {"plus", "x", "h"}) {
    for (const int rotors : {4, 6, 8}) {
      VehicleDraft draft;
      draft.name = "one", draft.layout = layout, draft.rotors = rotors;
      const MultirotorParameters p = ReadBack(draft);
      const double weight = 9.80665 * draft.mass_kg;
      EXPECT_EQ(LayoutOf(p).count, static_cast<std::size_t>(rotors));
      EXPECT_EQ(CannotFly(LayoutOf(p), LimitsOf(p.rotor), weight), std::nullopt) << layout << rotors;
      EXPECT_NEAR(MaxThrust_n(p), 2 * weight, 0.01 * weight);
      ++count;
    }
  }
  EXPECT_EQ(count, 9);
}

TEST_F(VehicleDrafts, WhatCannotFlyIsRefusedInWords) {
  VehicleDraft draft;
  draft.name = "lead", draft.mass_kg = 9, draft.kv_rpm_v = 400, draft.propeller_m = 0.5;
  Mistakes mistakes;
  EXPECT_EQ(VehicleText(draft, mistakes), "");
  draft.propeller_m = 0.2;
  VehicleText(draft, mistakes);
  ASSERT_EQ(mistakes.Texts().size(), 2u);
  EXPECT_THAT(mistakes.Texts()[0], HasSubstr("--propeller: 0.5 m across overlap: shafts are 0.354 m apart"));
  EXPECT_THAT(mistakes.Texts()[1], HasSubstr("--kv: 4 rotors of 0.2 m give"));
  EXPECT_THAT(mistakes.Texts()[1], HasSubstr("and 9 kg weigh 88.3 N"));
}

}  // namespace
}  // namespace kestrel::sim
