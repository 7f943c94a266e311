// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/instruction_set.h"

#include <gmock/gmock.h>
#include <hwy/targets.h>

#include <cstdlib>
#include <map>

#include "base/diagnostics.h"
#include "sim/machine.h"

namespace kestrel::sim {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Pair;

class InstructionSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (InstructionSets().empty()) GTEST_SKIP() << "there is nothing to choose on this processor";
  }
  void TearDown() override {
    hwy::SetSupportedTargetsForTest(0);
    hwy::DisableTargets(0);
    hwy::GetChosenTarget().DeInit();
    unsetenv("GLIBC_TUNABLES"), unsetenv("OPENCV_CPU_DISABLE");
  }
  static std::string Refusal(const std::string& set) {
    try {
      UseInstructionSet(set);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  static std::string Variable(const std::string& set, const std::string& name) {
    const auto all = EnvironmentOf(set);
    return std::map<std::string, std::string>(all.begin(), all.end()).at(name);
  }
};

TEST_F(InstructionSetTest, TheLeastIsThereAndIsInUseOnceItIsChosen) {
  EXPECT_EQ(Refusal("ssse3"), "");
  EXPECT_EQ(InstructionSet(), "ssse3");
}

TEST_F(InstructionSetTest, OneThatTheMachineHasNotIsRefusedWithThoseThatItHas) {
  hwy::SetSupportedTargetsForTest(HWY_SSSE3 | HWY_AVX2);
  EXPECT_EQ(Refusal("avx512"), "--isa: this machine has no avx512; valid: ssse3, avx2 here");
  EXPECT_EQ(Refusal("avx2"), "");
  EXPECT_EQ(Refusal("mmx"), "--isa: 'mmx' is no instruction set that can be chosen; valid: ssse3, avx2 here");
}

TEST_F(InstructionSetTest, TheCLibrarysOtherTunablesStay) {
  setenv("GLIBC_TUNABLES", "glibc.malloc.check=1:glibc.cpu.hwcaps=-SSE4_1", 1);
  EXPECT_EQ(Variable("ssse3", "GLIBC_TUNABLES"), "glibc.malloc.check=1:glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4");
  EXPECT_EQ(Variable("avx2", "GLIBC_TUNABLES"), "glibc.malloc.check=1");
}

// Or a process would begin itself again and again.
TEST_F(InstructionSetTest, WhatTheEnvironmentIsToHoldItHoldsOnceItDoes) {
  for (const std::string_view set : InstructionSets()) {
    const auto wanted = EnvironmentOf(std::string(set));
    for (const auto& [name, value] : wanted) setenv(name.c_str(), value.c_str(), 1);
    EXPECT_EQ(EnvironmentOf(std::string(set)), wanted) << set;
  }
}

TEST_F(InstructionSetTest, TheMachineSaysBothWhatIsThereAndWhatIsInUse) {
  const Machine best = ThisMachine();
  for (const char* name : {"instruction_set", "reciprocals", "c_library", "mathematics", "opencv", "lapack",
                           "embree", "mujoco", "build"})
    EXPECT_THAT(best, Contains(Pair(name, Not(IsEmpty()))));
  UseInstructionSet("ssse3");
  EXPECT_EQ(ThisMachine().at("instruction_set"), "ssse3");
  EXPECT_EQ(ThisMachine().at("mujoco"), best.at("mujoco"));
}

TEST(MachineDifferences, NamesWhatEitherHas) {
  const Machine a = {{"embree", "3"}, {"mujoco", "2"}, {"lapack", "x"}};
  const Machine b = {{"embree", "3"}, {"mujoco", "1"}, {"opencv", "4"}};
  EXPECT_THAT(MachineDifferences(a, a), IsEmpty());
  const auto differences = MachineDifferences(a, b);
  EXPECT_EQ(differences.size(), 3u);
  EXPECT_EQ(differences.at("mujoco"), std::pair(std::string("2"), std::string("1")));
  EXPECT_EQ(differences.at("lapack"), std::pair(std::string("x"), std::string("unknown")));
  EXPECT_EQ(differences.at("opencv"), std::pair(std::string("unknown"), std::string("4")));
}

}  // namespace
}  // namespace kestrel::sim
