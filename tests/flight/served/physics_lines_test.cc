// SPDX-License-Identifier: Apache-2.0
#include "flight/served/physics_lines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// What a shell makes of a command.
std::string Output(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 256> buffer{};
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe)) output += buffer.data();
  if (pipe) pclose(pipe);
  return output;
}

TEST(PhysicsLines, ArduPilotsCommandNamesItsOwnDefaultsAndAFileThatIsThere) {
  const std::string lines = PhysicsLines("ardupilot", "udp://127.0.0.1:9002", "pelican", "kestrel fly hover");
  EXPECT_THAT(
      lines,
      HasSubstr("arducopter --model JSON:127.0.0.1 --defaults Tools/autotest/default_params/copter.parm,/"));
  const std::size_t from = lines.find("copter.parm,") + 12;
  const std::string file = lines.substr(from, lines.find('\n', from) - from);
  EXPECT_TRUE(std::filesystem::exists(file)) << file;
  EXPECT_THAT(lines,
              HasSubstr("kestrel fly hover --autopilot mavlink:tcp://127.0.0.1:5760 --take-control --arm\n"));
  EXPECT_THAT(PhysicsLines("ardupilot", "udp://192.168.1.5:9012", "pelican", ""),
              HasSubstr("--model JSON:192.168.1.5 --sim-port-out 9012 "));
}

TEST(PhysicsLines, Px4sCommandTakesItsParametersFromTheFile) {
  const std::string lines = PhysicsLines("px4", "tcp://127.0.0.1:4562", "pelican", "kestrel fly hover");
  EXPECT_THAT(lines, HasSubstr("build/px4_sitl_default/bin/px4 -i 2\n"));
  EXPECT_THAT(lines, HasSubstr("kestrel fly hover --autopilot mavlink:udpin://127.0.0.1:14542 "));
  EXPECT_THAT(lines, Not(HasSubstr("PX4_SIM_HOST_ADDR")));
  const std::size_t from = lines.find("env PX4"), to = lines.find(" build/px4");
  ASSERT_NE(to, std::string::npos);
  const std::string variables = Output(lines.substr(from, to - from) + " env");
  EXPECT_THAT(variables, HasSubstr("PX4_SIM_MODEL=none_iris\n"));
  EXPECT_THAT(variables, HasSubstr("PX4_PARAM_CA_ROTOR_COUNT=4\n"));
  EXPECT_THAT(variables, HasSubstr("PX4_PARAM_CA_ROTOR2_KM=-"));
  EXPECT_THAT(PhysicsLines("px4", "tcp://192.168.1.5:4560", "pelican", ""),
              HasSubstr("PX4_SIM_HOST_ADDR=192.168.1.5"));
  EXPECT_THAT(PhysicsLines("px4", "tcp://127.0.0.1:5000", "pelican", "kestrel fly hover"),
              Not(HasSubstr("bin/px4")));
}

class OwnVehicle : public InTemporaryFolder {};

TEST_F(OwnVehicle, ParametersThatAreNotThereAreNotNamedAndHowToWriteThemIsSaid) {
  const std::filesystem::path file = folder_ / "mine.yaml";
  std::ofstream(file) << "mass_kg: 1\n";
  const std::string lines = PhysicsLines("ardupilot", "udp://127.0.0.1:9002", file.string(), "");
  EXPECT_THAT(lines, HasSubstr("copter.parm\n"));
  EXPECT_THAT(lines, HasSubstr("kestrel vehicle parameters " + file.string() +
                               " --autopilot ardupilot --out " + folder_.string() + "\n"));
  EXPECT_THAT(lines, Not(HasSubstr("kestrel fly")));               // no camera is served
  std::ofstream(folder_ / "ardupilot.parm") << "FRAME_CLASS 1\n";  // of whoever
  std::ofstream(folder_ / "mine.ardupilot.parm") << "FRAME_CLASS 1\n";
  EXPECT_THAT(PhysicsLines("ardupilot", "udp://127.0.0.1:9002", file.string(), ""),
              HasSubstr("copter.parm," + (folder_ / "mine.ardupilot.parm").string() + "\n"));
}

}  // namespace
}  // namespace kestrel::flight
