// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "app/flight/recorded_states.h"
#include "app/flight/replay_command.h"
#include "base/diagnostics.h"
#include "base/mcap/writer.h"
#include "base/ros/cdr.h"
#include "base/ros/schemas.h"
#include "base/ros/sensor_messages.h"
#include "flight/simulated/runner.h"
#include "geometry/ros_frames.h"
#include "records/recording.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A flight as its recording has it, in an MCAP as a real aircraft's computer would have logged it.
class ReplayLogTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    flight::RunOptions options;
    options.folder = folder_;
    options.video = false;
    options.images = true;
    flight::RunFlight(flight::LoadScenario("hover", {"duration_s=1.5", "start.settle_s=1"}), options);
    recording_.emplace(folder_);
    arguments_.folder = (folder_ / "flight.mcap").string();
    arguments_.scenario = "hover";
    arguments_.csv = (folder_ / "seen.csv").string();
    arguments_.quiet = true;
  }
  static std::uint16_t Add(mcap::Writer& writer, const std::string& topic, const char* type) {
    return writer.Add({.topic = topic,
                       .message_encoding = "cdr",
                       .schema = {.name = type, .encoding = "ros2msg", .data = ros::SchemaOf(type)}});
  }
  static ros::Time At(double t_s) { return ros::TimeOf(std::llround(1e9 * (100 + t_s))); }

  void Write(bool with_odometry) const {
    mcap::Writer writer(arguments_.folder);
    const auto camera = Add(writer, "/cam/image_raw", ros::Image::kType),
               imu = Add(writer, "/imu", ros::Imu::kType);
    std::uint16_t odometry = 0;
    if (with_odometry) odometry = Add(writer, "/odometry", ros::Odometry::kType);
    std::uint64_t logged_ns = 1;
    for (std::size_t i = 0; i < recording_->frames().size(); ++i, ++logged_ns) {
      const control::VehicleState& state = recording_->frames()[i].state;
      const Eigen::Quaterniond R = WorldBodyToRos(state.R_NB);
      const Eigen::Vector3d p = WorldToRos(state.p_NB), v = BodyToRos(state.R_NB.conjugate() * state.v_N),
                            w = BodyToRos(state.w_B);
      ros::Odometry odometry_message;
      odometry_message.header.stamp = At(state.t_s);
      odometry_message.pose = {{p.x(), p.y(), p.z()}, {R.x(), R.y(), R.z(), R.w()}};
      odometry_message.twist = {{v.x(), v.y(), v.z()}, {w.x(), w.y(), w.z()}};
      if (with_odometry) writer.Write(odometry, logged_ns, ros::ToCdr(odometry_message));
      ros::Imu imu_message;
      imu_message.header.stamp = At(state.t_s);
      imu_message.orientation_covariance[0] = -1;
      writer.Write(imu, logged_ns, ros::ToCdr(imu_message));
      const vision::Frame frame = recording_->At(i);
      ros::Image image;
      image.header.stamp = At(frame.t_s);
      image.width = static_cast<std::uint32_t>(frame.image.cols);
      image.height = static_cast<std::uint32_t>(frame.image.rows);
      image.step = image.width, image.encoding = "mono8";
      image.data.assign(frame.image.datastart, frame.image.dataend);
      writer.Write(camera, logged_ns, ros::ToCdr(image));
    }
    writer.Close();
  }
  std::string Refusal() const {
    try {
      ReplayCommand(arguments_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  }

  std::optional<records::Recording> recording_;
  ReplayArguments arguments_;
};

TEST_F(ReplayLogTest, TheMissionAsksForWhatItAskedForInFlight) {
  Write(true);
  ASSERT_EQ(recording_->At(0).image.type(), CV_8UC1);
  EXPECT_TRUE(ReplayCommand(arguments_));
  std::ifstream csv(arguments_.csv);
  std::string line;
  std::getline(csv, line);
  EXPECT_THAT(line, ::testing::StartsWith("image,stamp_ns,t_s,phase,target,outcome,setpoint_vx_m_s,"));
  std::size_t compared = 0, rows = 0;
  for (; std::getline(csv, line); ++rows) {
    const records::RecordedDecision& then = recording_->frames()[rows].decision;
    std::istringstream cells(line);
    std::vector<std::string> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    ASSERT_GT(row.size(), 5u);
    EXPECT_EQ(row[3], then.phase);
    EXPECT_EQ(row[4], then.target);
    for (std::size_t k = 0; k < then.numbers.size() && k + 6 < row.size(); ++k) {
      ASSERT_EQ(row[k + 6].empty(), !then.numbers[k]) << k;
      if (!then.numbers[k]) continue;
      // What is lost is in the frames' turning and in times to the nanosecond.
      EXPECT_NEAR(std::stod(row[k + 6]), *then.numbers[k], 1e-6 * (1 + std::abs(*then.numbers[k]))) << k;
      ++compared;
    }
  }
  EXPECT_EQ(rows, recording_->frames().size());
  EXPECT_GT(compared, 5 * rows);
}

TEST_F(ReplayLogTest, AnImusOrientationAndRatesAreAStateWithoutAPlace) {
  const control::VehicleState& flown = recording_->frames()[5].state;
  const Eigen::Quaterniond R = WorldBodyToRos(flown.R_NB);
  mcap::Writer writer(arguments_.folder);
  ros::Imu message;
  message.header.stamp = At(flown.t_s);
  message.orientation = {R.x(), R.y(), R.z(), R.w()};
  message.angular_velocity = {0.1, 0.2, 0.3};
  writer.Write(Add(writer, "/imu", ros::Imu::kType), 7, ros::ToCdr(message));
  writer.Close();
  Mistakes mistakes;
  const RecordedStates states = ReadRecordedStates(arguments_.folder, "", mistakes);
  ASSERT_TRUE(mistakes.empty());
  ASSERT_EQ(states.states.size(), 1u);
  EXPECT_FALSE(states.placed);
  EXPECT_EQ(states.logged_ns[0], 7);
  EXPECT_LT(states.states[0].R_NB.angularDistance(flown.R_NB), 1e-9);
  EXPECT_EQ(states.states[0].w_B, Eigen::Vector3d(0.1, -0.2, -0.3));  // forward, right, down
  EXPECT_EQ(states.states[0].p_NB, Eigen::Vector3d::Zero());
}

TEST_F(ReplayLogTest, WhatIsMissingIsTold) {
  Write(false);
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("message 1 of /imu"), HasSubstr("has no orientation")));
  arguments_.scenario = "";
  arguments_.topic = "/other";
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--scenario"), HasSubstr("valid: /cam/image_raw")));
  arguments_.folder = folder_.string();
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("--topic"), HasSubstr("is no MCAP")));
}

}  // namespace
}  // namespace kestrel::app
