// SPDX-License-Identifier: Apache-2.0
// Vehicles, worlds and pads that are files beside the scenario.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/file/files.h"
#include "base/yaml/yaml_fields.h"
#include "flight/simulated/scenario.h"
#include "tests/support/diagnostic_texts.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ModelPaths : public InTemporaryFolder {
 protected:
  std::string Write(const fs::path& file, const std::string& text) const {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
    return (folder_ / file).string();
  }
  std::vector<std::string> Refused(const std::string& file) const {
    try {
      LoadScenario(file);
    } catch (const InputError& e) {
      return Texts(e);
    }
    return {};
  }
};

constexpr char kHexacopter[] =
    "mass_kg: 1.5\n"
    "rotors:\n"
    "  - {x_m: 0.22, y_m: 0.12, spin: counterclockwise}\n"
    "  - {x_m: 0, y_m: 0.25, spin: clockwise}\n"
    "  - {x_m: -0.22, y_m: 0.12, spin: counterclockwise}\n"
    "  - {x_m: -0.22, y_m: -0.12, spin: clockwise}\n"
    "  - {x_m: 0, y_m: -0.25, spin: counterclockwise}\n"
    "  - {x_m: 0.22, y_m: -0.12, spin: clockwise}\n";

TEST_F(ModelPaths, VehicleWorldAndPadMayBeFilesBesideTheScenario) {
  fs::create_directories(folder_ / "flights");
  fs::copy(Root() / "models/worlds/airfield", folder_ / "flights/world", fs::copy_options::recursive);
  fs::copy(Root() / "models/pads/helipad", folder_ / "flights/pad", fs::copy_options::recursive);
  Write("flights/vehicles/hexa.yaml", kHexacopter);
  const std::string file = Write("flights/a.yaml",
                                 "mission: pose\nvehicle: vehicles/hexa.yaml\nworld: world/airfield.xml\n"
                                 "pad: {name: pad/helipad.yaml}\n");
  const LoadedScenario loaded = LoadScenario(file);
  const auto& vehicle = std::get<sim::MultirotorParameters>(loaded.simulator.vehicle);
  EXPECT_EQ(vehicle.rotors.size(), 6u);
  EXPECT_THAT(loaded.simulator.scene.vehicle_shape, HasSubstr("vehicle_rotor_6"));
  EXPECT_EQ(loaded.simulator.scene.world, folder_ / "flights/world/airfield.xml");
  EXPECT_EQ(loaded.simulator.scene.pad_texture, folder_ / "flights/pad/helipad.png");
  // And the resolved scenario means the same files from wherever it lies.
  const LoadedScenario again = LoadScenario(Write("runs/1/again.yaml", ToYaml(loaded.scenario)));
  EXPECT_EQ(std::get<sim::MultirotorParameters>(again.simulator.vehicle).rotors.size(), 6u);
  EXPECT_EQ(again.simulator.scene.world, loaded.simulator.scene.world);
}

TEST_F(ModelPaths, EachThatIsNotThereIsTold) {
  const std::string file =
      Write("a.yaml", "mission: pose\nvehicle: v/none.yaml\nworld: w/none.xml\npad: {name: p/none.yaml}\n");
  const std::vector<std::string> told = Refused(file);
  for (const char* each :
       {":2: vehicle: there is no file 'v/none.yaml'", ":3: world: there is no file 'w/none.xml'", ":4: pad"})
    EXPECT_THAT(told, ::testing::Contains(HasSubstr(file + each)));
}

TEST_F(ModelPaths, RotorsThatCannotFlyAreToldWithTheLineOfTheirList) {
  std::string text = kHexacopter;
  for (std::size_t at = 0; (at = text.find("counterclockwise", at)) != std::string::npos;)
    text.replace(at, 16, "clockwise");
  const std::string vehicle = Write("hexa.yaml", text);
  EXPECT_THAT(Refused(Write("a.yaml", "mission: pose\nvehicle: hexa.yaml\n")),
              ElementsAre(AllOf(HasSubstr(vehicle + ":2: rotors: the rotors cannot give"),
                                HasSubstr("thrust and yaw cannot be had alone"), HasSubstr("valid: "))));
}

}  // namespace
}  // namespace kestrel::flight
