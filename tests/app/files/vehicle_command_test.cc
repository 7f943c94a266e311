// SPDX-License-Identifier: Apache-2.0
#include "app/files/vehicle_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/diagnostics.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

class VehicleCommands : public InTemporaryFolder {
 protected:
  VehicleArguments Parameters(const std::string& vehicle, const std::string& autopilot) const {
    VehicleArguments a;
    a.parameters = true;
    a.vehicle = vehicle, a.autopilot = autopilot, a.out = folder_;
    return a;
  }
  static std::string Refusal(const VehicleArguments& a) {
    try {
      VehicleCommand(a);
      return {};
    } catch (const InputError& e) {
      return e.what();
    }
  }
};

TEST_F(VehicleCommands, TheParameterFilesOfEachMultirotorAreWhatTheCommandWrites) {
  int multirotors = 0, others = 0;
  for (const auto& folder : fs::directory_iterator(KESTREL_SOURCE_DIR "/models/vehicles")) {
    const std::string name = folder.path().filename();
    const bool helicopter =
        Content(folder.path() / (name + ".yaml")).find("\nkind: helicopter") != std::string::npos;
    for (const auto& [autopilot, file] : {std::pair{"ardupilot", "ardupilot.parm"}, {"px4", "px4.params"}}) {
      if (helicopter) {
        EXPECT_THAT(Refusal(Parameters(name, autopilot)), HasSubstr("this aircraft is none"));
        EXPECT_FALSE(fs::exists(folder.path() / file));
        ++others;
        continue;
      }
      VehicleCommand(Parameters(name, autopilot));
      EXPECT_EQ(Content(folder.path() / file), Content(folder_ / file)) << name;
      fs::remove(folder_ / file);
      ++multirotors;
    }
  }
  EXPECT_EQ(multirotors, 2);
  EXPECT_EQ(others, 4);
}

TEST_F(VehicleCommands, AVehicleThatWasBegunHasParametersToo) {
  VehicleArguments begin;
  begin.draft.name = "mine", begin.draft.rotors = 6, begin.out = folder_;
  VehicleCommand(begin);
  const std::string file = folder_ / "mine.yaml";
  VehicleCommand(Parameters(file, "ardupilot"));
  VehicleCommand(Parameters(file, "px4"));
  EXPECT_THAT(Content(folder_ / "mine.ardupilot.parm"), HasSubstr("\nFRAME_CLASS 2\nFRAME_TYPE 1\n"));
  EXPECT_THAT(Content(folder_ / "mine.px4.params"), HasSubstr("\tCA_ROTOR_COUNT\t6\t6\n"));
}

TEST_F(VehicleCommands, AFileOfAnotherKindIsNoVehicle) {
  for (const char* name : {"mine.yml", "mine.parm"}) {
    std::ofstream(folder_ / name) << "mass_kg: 1\n";
    EXPECT_THAT(Refusal(Parameters(folder_ / name, "px4")), HasSubstr("ends in neither .yaml nor .xml"))
        << name;
  }
}

TEST_F(VehicleCommands, WhatCannotBeWrittenIsRefused) {
  EXPECT_THAT(Refusal(Parameters("no_such_vehicle", "px4")), HasSubstr("no_such_vehicle"));
  EXPECT_EQ(Refusal(Parameters("pelican", "px4")), "");
  EXPECT_THAT(Refusal(Parameters("pelican", "px4")), HasSubstr("is there already"));
}

}  // namespace
}  // namespace kestrel::app
