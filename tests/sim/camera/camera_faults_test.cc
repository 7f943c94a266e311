// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/camera_faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

namespace kestrel::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

CameraFault Fault(const char* type, double from_s, double until_s) {
  CameraFault f;
  f.type = type, f.from_s = from_s, f.until_s = until_s;
  return f;
}

std::vector<std::pair<double, std::string>> Changes(const CameraFaults& faults, double until_s = 1e12) {
  std::vector<std::pair<double, std::string>> changes;
  for (const CameraCondition& c : faults.ChangesUntil(until_s)) changes.emplace_back(c.from_s, c.name);
  return changes;
}

TEST(CameraFaults, WithoutAnyTheCameraIsOk) {
  const CameraFaults none({}, 1, 60);
  EXPECT_EQ(none.At(0).name, "ok");
  EXPECT_EQ(none.At(1e6).name, "ok");
  EXPECT_TRUE(none.ChangesUntil(1e6).empty());
}

TEST(CameraFaults, LastFromTheirBeginningUpToTheirEnd) {
  const CameraFaults faults({Fault("off", 2, 3), Fault("garbage", 0, 1)}, 1, 60);
  EXPECT_THAT(Changes(faults), ElementsAre(Pair(0, "garbage"), Pair(1, "ok"), Pair(2, "off"), Pair(3, "ok")));
  EXPECT_THAT(Changes(faults, 1.5), ElementsAre(Pair(0, "garbage"), Pair(1, "ok")));
  EXPECT_THAT(Changes(faults, 2), ElementsAre(Pair(0, "garbage"), Pair(1, "ok"), Pair(2, "off")));
  EXPECT_TRUE(faults.At(0).garbage);
  EXPECT_FALSE(faults.At(1).garbage);
  EXPECT_FALSE(faults.At(1.999).off);
  EXPECT_TRUE(faults.At(2).off);
  EXPECT_TRUE(faults.At(1000 * 0.002).off);  // times are multiples of a step, give or take their rounding
  EXPECT_TRUE(faults.At(2.999).off);
  EXPECT_FALSE(faults.At(3).off);
}

TEST(CameraFaults, ThatMeetAddUp) {
  CameraFault slow = Fault("slow", 1, 6), late = Fault("delayed", 2, 5), later = Fault("delayed", 3, 4),
              some = Fault("intermittent", 3, 6), few = Fault("intermittent", 3, 6);
  slow.rate_hz = 4, late.delay_s = 0.2, later.delay_s = 0.3, some.loss = 0.5, few.loss = 0.2;
  const CameraFaults faults({slow, late, later, some, few}, 1, 60);
  EXPECT_THAT(
      Changes(faults),
      ElementsAre(Pair(1, "slow"), Pair(2, "delayed + slow"), Pair(3, "delayed + intermittent + slow"),
                  Pair(4, "delayed + intermittent + slow"), Pair(5, "intermittent + slow"), Pair(6, "ok")));
  const CameraCondition& c = faults.At(3.5);
  EXPECT_EQ(c.period_s, 0.25);
  EXPECT_DOUBLE_EQ(c.delay_s, 0.5);
  EXPECT_DOUBLE_EQ(c.loss, 0.6);  // 1 - 0.5 * 0.8
  EXPECT_DOUBLE_EQ(faults.At(4.5).delay_s, 0.2);
  EXPECT_EQ(faults.At(7).period_s, 0);
}

TEST(CameraFaults, OneOfProbabilityComesInThatShareOfTheRuns) {
  CameraFault f = Fault("stuck", 1, 2);
  f.probability = 0.3;
  int there = 0;
  constexpr int kRuns = 2000;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) there += CameraFaults({f}, seed, 60).At(1.5).stuck;
  EXPECT_NEAR(there / static_cast<double>(kRuns), 0.3, 0.035);  // three and a half deviations
  f.probability = 0;
  EXPECT_TRUE(Changes(CameraFaults({f}, 1, 60)).empty());
}

TEST(CameraFaults, OneOfARateComesAndGoesWithinItsTime) {
  CameraFault f = Fault("off", 100, 3100);
  f.rate_per_min = 12, f.length_s = 2;
  const CameraFaults faults({f}, 4, 3600);
  const auto changes = Changes(faults);
  ASSERT_EQ(changes.size() % 2, 0u);
  double off_s = 0;
  for (std::size_t i = 0; i < changes.size(); i += 2) {
    EXPECT_EQ(changes[i].second, "off");
    EXPECT_EQ(changes[i + 1].second, "ok");
    EXPECT_GE(changes[i].first, 100);
    EXPECT_LE(changes[i + 1].first, 3100);
    EXPECT_NEAR(changes[i + 1].first - changes[i].first, 2, i + 2 < changes.size() ? 1e-9 : 2);
    off_s += changes[i + 1].first - changes[i].first;
  }
  // 5 s of waiting on average, then 2 s of the fault
  EXPECT_NEAR(off_s / 3000, 2.0 / 7, 0.04);
  EXPECT_NE(Changes(CameraFaults({f}, 5, 3600)), changes);
  EXPECT_EQ(Changes(CameraFaults({f}, 4, 3600)), changes);
}

TEST(CameraFaults, OneMoreDoesNotShiftThoseBefore) {
  CameraFault f = Fault("stuck", 0, 100);
  f.rate_per_min = 6;
  const CameraFaults one({f}, 4, 100), two({f, Fault("garbage", 200, 201)}, 4, 100);
  auto changes = Changes(two);
  ASSERT_GE(changes.size(), 4u);
  changes.resize(changes.size() - 2);
  EXPECT_EQ(changes, Changes(one));
}

TEST(CameraFaults, AnIntermittentCameraLosesItsShareByTheSeed) {
  CameraFault f = Fault("intermittent", 0, 1e6);
  f.loss = 0.25;
  const CameraFaults faults({f}, 7, 60), other({f}, 8, 60);
  int lost = 0, alike = 0, pairs = 0;
  constexpr int kTicks = 20000;
  for (int k = 0; k < kTicks; ++k) {
    const bool loses = faults.Loses(faults.At(1), k);
    lost += loses;
    pairs += loses && faults.Loses(faults.At(1), k + 1);
    alike += loses == other.Loses(other.At(1), k);
  }
  EXPECT_NEAR(lost / static_cast<double>(kTicks), 0.25, 0.012);
  EXPECT_NEAR(pairs / static_cast<double>(kTicks), 0.0625, 0.007);  // one after the other by chance alone
  EXPECT_NEAR(alike / static_cast<double>(kTicks), 0.625, 0.014);
  EXPECT_FALSE(faults.Loses(CameraCondition{}, 3));
}

}  // namespace
}  // namespace kestrel::sim
