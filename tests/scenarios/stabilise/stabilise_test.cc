// SPDX-License-Identifier: Apache-2.0
#include "scenarios/stabilise/stabilise.h"

#include <gmock/gmock.h>

#include "base/diagnostics.h"

namespace kestrel::scenarios {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> MistakesOf(const StabiliseFlight& flight) {
  Mistakes mistakes;
  CheckFlight(flight, {"stabilise.yaml", 3}, mistakes);
  return mistakes.Texts();
}

TEST(StabiliseFlight, DoesNotWaitForItsOwnEnd) {
  StabiliseFlight flight;
  EXPECT_THAT(MistakesOf(flight), IsEmpty());
  flight.stabiliser.mode = "offline";
  EXPECT_THAT(MistakesOf(flight), ElementsAre(HasSubstr("flight.stabiliser.mode")));
}

TEST(StabiliseFlight, IsLevelledByAnAttitudeAlone) {
  StabiliseFlight flight;
  flight.stabiliser.level = true;
  EXPECT_THAT(MistakesOf(flight), ElementsAre(HasSubstr("flight.stabiliser.level")));
  flight.stabiliser.by = "both";
  EXPECT_THAT(MistakesOf(flight), IsEmpty());
}

}  // namespace
}  // namespace kestrel::scenarios
