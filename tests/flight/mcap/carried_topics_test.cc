// SPDX-License-Identifier: Apache-2.0
#include "flight/mcap/carried_topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/mcap/reader.h"
#include "base/ros/sensor_messages.h"
#include "records/mcap/flight_mcap.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

class CarriedTopicsTest : public InTemporaryFolder {
 protected:
  template <class Message>
  std::vector<Message> All(const std::string& topic) const {
    mcap::Reader reader(folder_ / "flight.mcap");
    reader.Select({topic});
    std::vector<Message> all;
    while (const auto message = reader.Next()) {
      all.push_back(ros::FromCdr<Message>(message->data));
      if constexpr (requires { all.back().header; }) {
        EXPECT_EQ(static_cast<std::uint64_t>(ros::Nanoseconds(all.back().header.stamp)),
                  message->publish_time_ns);
      }
    }
    return all;
  }
};

TEST_F(CarriedTopicsTest, ReadingsHaveTheirStampsAndTheAxesOfRos) {
  sim::InstrumentParameters instruments;
  instruments.imu.emplace();
  instruments.imu->rate_hz = 500, instruments.imu->gyroscope_noise_density = 2e-3;
  instruments.imu->position_m = {0.1, 0.2, 0.3};
  instruments.rangefinder.emplace();
  sim::Readings readings;
  readings.imu = {{2'000'001, {0.1, 0.2, 0.3}, {0.5, 0.25, -9.81}}, {4'000'002, {}, {}}};
  sim::TruthSample truth;
  truth.t_ns = 2'000'001;
  truth.X_NB.p = {1, 2, -3};
  readings.truth = {truth};
  readings.gps = {{3'000'000, {10, 20, -30}, {1, 2, 3}}};
  readings.barometer = {{5, 300, 98'000}};
  readings.magnetometer = {{6, {1e-5, 2e-5, 3e-5}}};
  readings.rangefinder = {{7, 4.5}};
  {
    records::FlightMcap mcap(folder_ / "flight.mcap", {});
    CarriedTopics(instruments, {}).Write(readings, {}, 0.005, mcap);
    mcap.Close();
  }
  const auto imu = All<ros::Imu>("/imu");
  ASSERT_EQ(imu.size(), 2u);
  EXPECT_EQ(ros::Nanoseconds(imu[0].header.stamp), 2'000'001);
  EXPECT_EQ(imu[0].angular_velocity.y, -0.2);
  EXPECT_EQ(imu[0].linear_acceleration.z, 9.81);  // at rest it pushes up
  EXPECT_EQ(imu[0].orientation_covariance[0], -1);
  EXPECT_NEAR(imu[0].angular_velocity_covariance[4], 4e-6 * 500, 1e-12);
  const auto at = All<ros::Odometry>("/imu/truth");
  ASSERT_EQ(at.size(), 1u);
  EXPECT_EQ(at[0].pose.translation.x, 2);
  EXPECT_EQ(at[0].pose.translation.z, 3);
  const auto gps = All<ros::PoseStamped>("/gps/position");
  ASSERT_EQ(gps.size(), 1u);
  EXPECT_EQ(gps[0].pose.translation.x, 20);  // east
  ASSERT_EQ(All<ros::TwistStamped>("/gps/velocity").size(), 1u);
  ASSERT_EQ(All<ros::FluidPressure>("/barometer").size(), 1u);
  EXPECT_EQ(All<ros::FluidPressure>("/barometer")[0].fluid_pressure, 98'000);
  ASSERT_EQ(All<ros::MagneticField>("/magnetometer").size(), 1u);
  EXPECT_EQ(All<ros::MagneticField>("/magnetometer")[0].magnetic_field.z, -3e-5);
  ASSERT_EQ(All<ros::Range>("/rangefinder").size(), 1u);
  EXPECT_EQ(All<ros::Range>("/rangefinder")[0].range, 4.5f);
  const auto tf = All<ros::TfMessage>("/tf");
  ASSERT_EQ(tf.size(), 1u);
  ASSERT_EQ(tf[0].transforms.size(), 2u);
  EXPECT_EQ(tf[0].transforms[0].child_frame_id, "imu");
  EXPECT_EQ(tf[0].transforms[0].transform.translation.y, -0.2);
  const ros::Quaternion& q = tf[0].transforms[1].transform.rotation;  // the beam, x there, points down
  EXPECT_LT(
      (Eigen::Quaterniond(q.w, q.x, q.y, q.z) * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitZ()).norm(),
      1e-12);
}

}  // namespace
}  // namespace kestrel::flight
