// SPDX-License-Identifier: Apache-2.0
// Multirotors of each layout, as `kestrel vehicle new` begins them, in the flights and by the criteria that the
// Pelican has, on seeds that no tuning was done on.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <utility>

#include "sim/vehicle_draft.h"
#include "tests/acceptance/flown.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

class VehicleFlights : public InTemporaryFolder {
 protected:
  std::string Vehicle(const std::string& layout, int rotors) {
    sim::VehicleDraft draft;
    draft.name = layout + std::to_string(rotors);
    draft.layout = layout, draft.rotors = rotors, draft.mass_kg = 1.6;
    Mistakes mistakes;
    const auto file = folder_ / (draft.name + ".yaml");
    std::ofstream(file) << sim::VehicleText(draft, mistakes);
    mistakes.ThrowIfAny();
    return "vehicle=" + file.string();
  }
};

const std::pair<const char*, int> kLayouts[] = {{"plus", 4}, {"x", 4}, {"h", 4},    {"x", 6},
                                                {"plus", 6}, {"x", 8}, {"plus", 8}, {"h", 6}};

TEST_F(VehicleFlights, EachLayoutHoversOverThePad) {
  std::uint64_t seed = 111;
  for (const auto& [layout, rotors] : kLayouts) {
    SCOPED_TRACE(layout + std::to_string(rotors));
    ExpectCriteria(Flown("hover", seed++, {Vehicle(layout, rotors), "duration_s=30"}));
  }
  EXPECT_EQ(seed, 111u + std::size(kLayouts));
}

TEST_F(VehicleFlights, EachLayoutLandsOnThePad) {
  std::uint64_t seed = 131;
  for (const auto& [layout, rotors] : kLayouts) {
    SCOPED_TRACE(layout + std::to_string(rotors));
    const flight::FlightResult result = Flown("landing", seed++, {Vehicle(layout, rotors)});
    EXPECT_EQ(result.summary.outcome, "landed");
    ExpectCriteria(result);
  }
  EXPECT_EQ(seed, 131u + std::size(kLayouts));
}

}  // namespace
}  // namespace kestrel
