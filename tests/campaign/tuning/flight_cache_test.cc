// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/flight_cache.h"

#include <gmock/gmock.h>

#include <atomic>
#include <fstream>
#include <stdexcept>

#include "tests/campaign/scripted_worker.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

using ::testing::HasSubstr;

class KeptFlightsTest : public InTemporaryFolder {
 protected:
  LoadedTune Tuning() const {
    std::ofstream(folder_ / "gains.yaml") << "pilot.servo.lambda_yaw_per_s: 1\n";
    std::ofstream(folder_ / "t.yaml") << "scenario: hover\n"
                                         "set: [gains="
                                      << (folder_ / "gains.yaml").string()
                                      << "]\n"
                                         "vary: {wind.mean_m_s: {uniform: [0, 6]}}\n"
                                         "gains: {pilot.servo.lambda_per_s: {low: 0.1, high: 4}}\n"
                                         "cost: {settle_s: {scale: 1}}\n";
    return LoadTune(folder_ / "t.yaml");
  }
  std::atomic<bool> stopped_ = false;
  SharedFlights known_;
};

TEST_F(KeptFlightsTest, FlightsThatAreAlikeAreFlownOnce) {
  FlightCache flights(Tuning(), folder_, 2, ScriptedWorker(folder_), stopped_, known_);
  const auto order = [](std::int64_t row, const char* set) {
    return RunOrder{row, "hover", {set}, {}, false};
  };
  EXPECT_EQ(flights({order(0, "a=1"), order(1, "a=2"), order(2, "a=1"), order(3, "a=1")}).size(), 4u);
  EXPECT_THAT(RowsIn(folder_ / "given.txt"), ::testing::UnorderedElementsAre(0, 1));
  const std::vector<RunResult> rows = flights.Rows(0, 4);
  for (const int same : {2, 3})
    EXPECT_EQ(rows.at(same).metrics.at("error_m"), rows.at(0).metrics.at("error_m"));
  EXPECT_NE(rows.at(1).metrics.at("error_m"), rows.at(0).metrics.at("error_m"));
  flights({order(0, "a=1"), order(4, "a=2")});
  EXPECT_EQ(RowsIn(folder_ / "given.txt").size(), 2u);
}

TEST_F(KeptFlightsTest, GainsThatChangeUnderWayEndIt) {
  FlightCache flights(Tuning(), folder_, 1, ScriptedWorker(folder_), stopped_, known_);
  flights({{0, "hover", {"a=1"}, {}, false}});
  std::ofstream(folder_ / "gains.yaml") << "pilot.servo.lambda_yaw_per_s: 2\n";
  try {
    flights({{1, "hover", {"a=2"}, {}, false}});
    ADD_FAILURE();
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("gains.yaml was changed while it was flown by"));
  }
}

}  // namespace
}  // namespace kestrel::campaign
