// SPDX-License-Identifier: Apache-2.0
#include "flight/mcap/carried_topics.h"

#include <algorithm>
#include <string>

#include "base/nanoseconds.h"
#include "base/ros/sensor_messages.h"
#include "geometry/ros_frames.h"
#include "geometry/tait_bryan.h"
#include "records/mcap/row_messages.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::flight {
namespace {

constexpr char kImuFrame[] = "imu", kRangeFrame[] = "rangefinder";
constexpr double kBeam_rad = 0.01;  // a laser's

ros::Header Stamped(std::int64_t t_ns, const char* frame) { return {ros::TimeOf(t_ns), frame}; }
ros::Vector3 RosVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
std::array<double, 9> Diagonal(double variance) { return {variance, 0, 0, 0, variance, 0, 0, 0, variance}; }

ros::Imu ImuMessage(const sim::ImuReading& reading, const sim::ImuParameters& imu) {
  const auto variance = [&](double density) { return density * density * imu.rate_hz; };
  ros::Imu message;
  message.header = Stamped(reading.t_ns, kImuFrame);
  message.orientation_covariance[0] = -1;  // it measures none
  message.angular_velocity = RosVector(BodyToRos(reading.w_I));
  message.angular_velocity_covariance = Diagonal(variance(imu.gyroscope_noise_density));
  message.linear_acceleration = RosVector(BodyToRos(reading.specific_force_I));
  message.linear_acceleration_covariance = Diagonal(variance(imu.accelerometer_noise_density));
  return message;
}

}  // namespace

void CarriedTopics::WritePlaces(double now_s, records::FlightMessages& messages) const {
  ros::TfMessage tf;
  const auto add = [&](const char* frame, const Pose& X) {
    tf.transforms.push_back({records::HeaderOf(now_s, records::kBodyFrame), frame, records::TransformOf(X)});
  };
  if (const auto& imu = instruments_.imu) {
    const TaitBryan angles{Radians(imu->yaw_deg), Radians(imu->pitch_deg), Radians(imu->roll_deg)};
    add(kImuFrame, BodyBodyToRos(Pose{Eigen::Quaterniond(RotationFromTaitBryan(angles)), imu->position_m}));
  }
  if (const auto& range = instruments_.rangefinder) {
    // ROS's beam leaves along x.
    const Eigen::Quaterniond R =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), BodyToRos(range->direction));
    add(kRangeFrame, {R, BodyToRos(range->position_m)});
  }
  const std::int64_t now_ns = Nanoseconds(now_s);
  if (!tf.transforms.empty()) messages.Write("/tf", now_ns, now_ns, tf);
}

void CarriedTopics::Write(const sim::Readings& readings, const std::vector<sim::CameraFrame>& frames,
                          double now_s, records::FlightMessages& messages) {
  if (!placed_) WritePlaces(now_s, messages);
  placed_ = true;
  const auto write = [&](const char* topic, std::int64_t t_ns, const auto& message) {
    messages.Write(topic, t_ns, t_ns, message);
  };
  for (const sim::ImuReading& each : readings.imu)
    write("/imu", each.t_ns, ImuMessage(each, *instruments_.imu));
  for (const sim::TruthSample& each : readings.truth) {
    Truth truth;
    truth.t_s = static_cast<double>(each.t_ns) * 1e-9;
    truth.X_NB = each.X_NB, truth.v_N = each.v_N, truth.w_B = each.w_B;
    ros::Odometry message = records::TruthMessage(truth);
    message.header.stamp = ros::TimeOf(each.t_ns);
    write("/imu/truth", each.t_ns, message);
  }
  for (const sim::GpsReading& each : readings.gps) {
    const ros::Header header = Stamped(each.t_ns, records::kMapFrame);
    write("/gps/position", each.t_ns, ros::PoseStamped{header, {RosVector(WorldToRos(each.p_N)), {}}});
    write("/gps/velocity", each.t_ns, ros::TwistStamped{header, {RosVector(WorldToRos(each.v_N)), {}}});
  }
  for (const sim::BarometerReading& each : readings.barometer)
    write("/barometer", each.t_ns,
          ros::FluidPressure{Stamped(each.t_ns, records::kBodyFrame), each.pressure_pa, 0});
  for (const sim::MagnetometerReading& each : readings.magnetometer)
    write(
        "/magnetometer", each.t_ns,
        ros::MagneticField{Stamped(each.t_ns, records::kBodyFrame), RosVector(BodyToRos(each.field_B)), {}});
  for (const sim::RangeReading& each : readings.rangefinder) {
    const sim::RangefinderParameters& p = *instruments_.rangefinder;
    ros::Range message;
    message.header = Stamped(each.t_ns, kRangeFrame);
    message.field_of_view = static_cast<float>(kBeam_rad);
    message.min_range = static_cast<float>(p.min_m), message.max_range = static_cast<float>(p.max_m);
    message.range = static_cast<float>(each.range_m);
    message.variance = static_cast<float>(p.noise_m * p.noise_m);
    write("/rangefinder", each.t_ns, message);
  }
  for (const sim::CameraFrame& each : frames) {
    const auto camera =
        std::find_if(cameras_.begin(), cameras_.end(), [&](const auto& c) { return c.name == each.name; });
    if (each.frame.image.empty() || camera == cameras_.end()) continue;
    messages.WriteFrame(each.name, camera->camera, vision::MountPose(camera->mount), each.frame, now_s);
  }
}

}  // namespace kestrel::flight
