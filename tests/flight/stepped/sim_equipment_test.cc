// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "base/nanoseconds.h"
#include "flight/stepped/sim.h"

namespace kestrel {
namespace {

// The scenario with a stereo pair and each instrument, small.
SimOptions Small() {
  SimOptions options;
  options.seed = 5;
  options.overrides = {"duration_s=1", "start.settle_s=1", "cameras.0.camera=thesis_2_8mm_binned",
                       "cameras.1.camera=thesis_2_8mm_binned"};
  return options;
}

// Whatever the steps, each reading and each frame is given once, in the order of time.
TEST(SimEquipment, IsGivenStepByStepWithoutAGapAndWithoutRepetition) {
  SimOptions options = Small();
  options.images = false;
  Sim sim("landing_sensors", options);
  std::int64_t next_imu_ns = 0;
  std::map<std::string, std::int64_t> sequence;
  const auto take = [&] {
    for (const sim::ImuReading& reading : sim.readings().imu) {
      ASSERT_EQ(reading.t_ns, next_imu_ns);
      next_imu_ns += 2'000'000;
    }
    EXPECT_EQ(next_imu_ns, Nanoseconds(sim.t_s()) + 2'000'000);  // all until now
    for (const sim::CameraFrame& frame : sim.camera_frames())
      EXPECT_EQ(frame.frame.sequence, sequence[frame.name]++);
  };
  sim.Reset();
  take();
  sim.Step();
  take();
  sim.Advance(0.152);
  take();
  EXPECT_EQ(sim.readings().imu.size(), 76u);
  sim.Advance(0.004);
  take();
  EXPECT_EQ(sim.readings().imu.size(), 2u);
  sim.Step();
  take();
  EXPECT_EQ(sequence["left"], sequence["right"]);
  EXPECT_GE(sequence["left"], 4);

  sim.Reset();
  EXPECT_EQ(sim.readings().imu.front().t_ns, 0);
}

TEST(SimEquipment, APairTriggeredByTheMainCameraIsExposedWithItsFrame) {
  Sim sim("landing_sensors", Small());
  Observation seen = sim.Reset();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(seen.frame);
    ASSERT_EQ(sim.camera_frames().size(), 2u);
    for (const sim::CameraFrame& frame : sim.camera_frames()) {
      EXPECT_EQ(Nanoseconds(frame.frame.t_s), Nanoseconds(seen.frame->t_s));
      EXPECT_EQ(frame.frame.image.size(), cv::Size(320, 240));
    }
    seen = sim.Step();
  }
}

}  // namespace
}  // namespace kestrel
