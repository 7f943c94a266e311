// SPDX-License-Identifier: Apache-2.0
// The program for real aircraft flies the simulated one over its wires, in real time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "scenarios/link_faults.h"
#include "tests/scenarios/temporary_folder.h"

namespace kestrel {
namespace {

using ::testing::IsEmpty;

constexpr int kAttempts = 3;
// What a machine may give up of a flight's time and still be said to have flown it in real time.
constexpr double kStretched_s = 0.5;

class WireFlights : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    setenv("KESTREL_HARDWARE_PROGRAM", KESTREL_HARDWARE_PROGRAM, 0);
  }

  // A flight in which time was not stretched. None: the machine is too busy to tell anything.
  std::optional<WireFlown> InRealTime(WireFlightOptions options) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      options.folder = folder_ / std::to_string(attempt);
      WireFlown flown = FlyOverWire(options);
      if (flown.Stretched_s() <= kStretched_s) return flown;
    }
    return std::nullopt;
  }
};

class EveryWire : public WireFlights, public ::testing::WithParamInterface<Wire> {};

TEST_P(EveryWire, TheHardwareProgramLands) {
  WireFlightOptions options;
  options.wire = GetParam();
  options.seed = 101;
  options.overrides = {"start.height_m=2", "start.scatter_m=0.3"};
  const auto flown = InRealTime(options);
  if (!flown) GTEST_SKIP() << "the machine is too busy to fly in real time: nothing is shown";
  EXPECT_TRUE(flown->Landed()) << flown->served.outcome << flown->served.error << "\n" << flown->said;
  EXPECT_LE(flown->TouchdownError_m(), 0.2);
  EXPECT_EQ(flown->status, 0) << flown->said;
  // Most of its setpoints can be traced to their images.
  EXPECT_GT(AddedLatency_s(*flown, GetParam()).size(), flown->images.size() / 2);
}

INSTANTIATE_TEST_SUITE_P(Wires, EveryWire, ::testing::ValuesIn(kWires),
                         [](const auto& wire) { return std::string(NameOf(wire.param)); });

TEST_F(WireFlights, ACutLinkAndACutCameraAreAnsweredAsWritten) {
  for (const FaultRow& row : kFaults) {
    if (row.fault != WireFault::kLinkCut && row.fault != WireFault::kCameraCut) continue;
    const auto flown = InRealTime(FlightWith(row, Wire::kMavlink, 101, {}));
    if (!flown) GTEST_SKIP() << "the machine is too busy to fly in real time: nothing is shown";
    EXPECT_THAT(JudgeFault(row, *flown, {}).wrong, IsEmpty()) << row.name << "\n" << flown->said;
  }
}

}  // namespace
}  // namespace kestrel
