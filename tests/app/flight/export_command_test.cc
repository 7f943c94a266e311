// SPDX-License-Identifier: Apache-2.0
#include "app/flight/export_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/mcap/reader.h"
#include "base/ros/cdr.h"
#include "base/ros/messages.h"
#include "flight/simulated/runner.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Log {
  std::map<std::string, std::vector<std::string>> by_topic;
  std::map<std::string, std::vector<std::uint64_t>> times;
};

Log ReadLog(const std::filesystem::path& file) {
  Log log;
  mcap::Reader reader(file);
  while (const auto message = reader.Next()) {
    log.by_topic[message->channel->topic].emplace_back(message->data);
    log.times[message->channel->topic].push_back(message->log_time_ns);
  }
  EXPECT_EQ(reader.damage(), "");
  return log;
}

class ExportCommandTest : public InTemporaryFolder {};

// What the flight itself wrote is the oracle.
TEST_F(ExportCommandTest, MakesTheLogThatTheFlightWouldHaveLeft) {
  const flight::LoadedScenario loaded =
      flight::LoadScenario("landing", {"duration_s=1", "start.settle_s=0.5", "seed=101"});
  flight::RunOptions options;
  options.folder = folder_;
  options.video = false;
  options.images = true;
  options.mcap = records::McapImages::kRaw;
  ASSERT_EQ(flight::RunFlight(loaded, options).summary.error, "");
  const Log flown = ReadLog(folder_ / "flight.mcap");
  EXPECT_THROW(ExportCommand({.folder = folder_.string()}), InputError);  // it holds more
  std::filesystem::remove(folder_ / "flight.mcap");

  ExportCommand({.folder = folder_.string(), .images = "raw", .quiet = true});
  const Log exported = ReadLog(folder_ / "flight.mcap");
  for (const char* topic : {"/camera/main/image_raw", "/camera/main/camera_info"}) {
    ASSERT_GT(flown.by_topic.at(topic).size(), 10u);
    EXPECT_EQ(exported.by_topic.at(topic), flown.by_topic.at(topic)) << topic;  // to the last byte
  }
  for (const char* topic : {"/truth", "/estimate", "/fix", "/setpoint/velocity", "/wind", "/tf"})
    EXPECT_EQ(exported.times.at(topic), flown.times.at(topic)) << topic;
  for (std::size_t i = 0; i < flown.by_topic.at("/truth").size(); ++i) {
    const auto a = ros::FromCdr<ros::Odometry>(flown.by_topic.at("/truth")[i]);
    const auto b = ros::FromCdr<ros::Odometry>(exported.by_topic.at("/truth")[i]);
    EXPECT_NEAR(a.pose.translation.x, b.pose.translation.x, 1e-7);
    EXPECT_NEAR(a.pose.translation.z, b.pose.translation.z, 1e-7);
    EXPECT_NEAR(std::abs(a.pose.rotation.w), std::abs(b.pose.rotation.w), 1e-8);
    EXPECT_NEAR(a.twist.linear.x, b.twist.linear.x, 1e-7);
  }
  // Between two rows the aircraft is nearly where the straight line has it.
  for (std::size_t i = 1; i < flown.by_topic.at("/tf").size(); ++i) {
    const auto a = ros::FromCdr<ros::TfMessage>(flown.by_topic.at("/tf")[i]).transforms.at(0).transform;
    const auto b = ros::FromCdr<ros::TfMessage>(exported.by_topic.at("/tf")[i]).transforms.at(0).transform;
    EXPECT_NEAR(a.translation.x, b.translation.x, 5e-3);
    EXPECT_NEAR(a.translation.z, b.translation.z, 5e-3);
  }
}

TEST_F(ExportCommandTest, WhatCannotBeIsRefused) {
  try {
    ExportCommand({.folder = folder_.string(), .to = "parquet", .images = "gif"});
    FAIL() << "it exported";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("'parquet' is no format; valid: mcap"), HasSubstr("'gif'"),
                                HasSubstr("holds no telemetry.csv"), HasSubstr("holds no scenario.yaml")));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace kestrel::app
