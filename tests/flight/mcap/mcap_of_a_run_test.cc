// SPDX-License-Identifier: Apache-2.0
// flight.mcap of a short flight with everything on board, against the flight's own rows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "base/mcap/reader.h"
#include "base/nanoseconds.h"
#include "base/ros/sensor_messages.h"
#include "flight/simulated/runner.h"
#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::IsEmpty;

class McapOfARunTest : public InTemporaryFolder {};

TEST_F(McapOfARunTest, ItHasEveryFrameAndReadingAndTheFlightStaysTheSame) {
  const LoadedScenario loaded =
      LoadScenario("landing_sensors", {"duration_s=0.5", "start.settle_s=0.5", "seed=101"});
  RunOptions options;
  options.folder = folder_;
  options.video = false;
  options.mcap = records::McapImages::kRaw;
  const FlightResult with = RunFlight(loaded, options), without = RunFlight(loaded, {});
  ASSERT_EQ(with.summary.error, "");
  EXPECT_EQ(with.summary.state_hash, without.summary.state_hash);
  EXPECT_EQ(with.summary.image_hash, without.summary.image_hash);

  mcap::Reader reader(folder_ / "flight.mcap");
  EXPECT_TRUE(reader.indexed());
  std::map<std::string, std::size_t> count;
  std::size_t row = 0;
  std::int64_t last_imu_ns = -1;
  while (const auto message = reader.Next()) {
    const std::string& topic = message->channel->topic;
    ++count[topic];
    if (topic == "/truth") {
      ASSERT_LT(row, with.rows.size());
      const Truth& truth = with.rows[row++].now;
      const auto odometry = ros::FromCdr<ros::Odometry>(message->data);
      EXPECT_EQ(static_cast<std::int64_t>(message->log_time_ns), Nanoseconds(truth.t_s));
      EXPECT_EQ(odometry.pose.translation.x, truth.X_NB.p.y());
      EXPECT_EQ(odometry.pose.translation.z, -truth.X_NB.p.z());
    } else if (topic == "/imu") {
      const auto imu = ros::FromCdr<ros::Imu>(message->data);
      const std::int64_t stamp_ns = ros::Nanoseconds(imu.header.stamp);
      if (last_imu_ns >= 0) {
        EXPECT_EQ(stamp_ns - last_imu_ns, 2'000'000);  // 500 Hz, to the nanosecond
      }
      last_imu_ns = stamp_ns;
    }
  }
  EXPECT_THAT(reader.damage(), IsEmpty());
  EXPECT_EQ(row, with.rows.size());
  ASSERT_GT(row, 5u);
  for (const char* topic : {"/camera/main/image_raw", "/camera/main/camera_info", "/estimate", "/tf"})
    EXPECT_GE(count[topic], row) << topic;
  for (const char* camera : {"left", "right"})
    EXPECT_GE(count[std::string("/camera/") + camera + "/image_raw"] + 1, row);
  EXPECT_GT(count["/imu"], 200u);
  EXPECT_EQ(count["/imu"], count["/imu/truth"]);
  EXPECT_GT(count["/events"], 0u);
  EXPECT_EQ(reader.ReadAttachment("scenario.yaml")->data, Content(folder_ / "scenario.yaml"));
  EXPECT_EQ(reader.ReadMetadata("kestrel").at("seed"), "101");
}

}  // namespace
}  // namespace kestrel::flight
