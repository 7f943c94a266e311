// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/mcap_frames.h"

#include <cmath>
#include <map>
#include <vector>

#include "base/mcap/reader.h"
#include "base/ros/cdr.h"
#include "base/ros/sensor_messages.h"
#include "vision/capture/recorded/mcap_topic.h"

namespace kestrel::vision {
namespace {

struct Joined {
  std::string parent;
  Pose X;  // of the frame in its parent
};
using Frames = std::map<std::string, Joined>;

// The frame that the header of a topic's first message names; empty: none.
std::string FrameOf(mcap::Reader& reader, const std::string& topic) {
  reader.Select({topic});
  const auto message = reader.Next();
  try {
    return message ? ros::FromCdr<ros::Header>(message->data).frame_id : "";
  } catch (const ros::CdrError&) {
    return "";
  }
}

Frames FramesOf(mcap::Reader& reader) {
  Frames frames;
  const std::vector<std::string> topics = TopicsOf(reader, {ros::TfMessage::kType});
  if (topics.empty()) return frames;
  reader.Select(topics);
  while (const auto message = reader.Next()) {
    try {
      for (const ros::TransformStamped& each : ros::FromCdr<ros::TfMessage>(message->data).transforms) {
        const auto& [t, q] = each.transform;
        const Eigen::Quaterniond R(q.w, q.x, q.y, q.z);
        constexpr double kNearOne = 0.01;
        if (std::abs(R.norm() - 1) < kNearOne)
          frames.try_emplace(each.child_frame_id,
                             Joined{each.header.frame_id, {R.normalized(), {t.x, t.y, t.z}}});
      }
    } catch (const ros::CdrError&) {  // another message may have it
    }
  }
  return frames;
}

// The poses of a frame in itself, its parent, that one's parent and so on.
std::map<std::string, Pose> PosesAbove(const Frames& frames, std::string frame) {
  std::map<std::string, Pose> poses;
  Pose X{Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()};
  while (poses.try_emplace(frame, X).second) {
    const auto joined = frames.find(frame);
    if (joined == frames.end()) break;
    X = joined->second.X * X, frame = joined->second.parent;
  }
  return poses;
}

}  // namespace

std::optional<Pose> PoseOnImuInMcap(const std::filesystem::path& file, const std::string& image_topic,
                                    const std::string& imu_topic) {
  mcap::Reader reader(file);
  Mistakes unsaid;
  const auto imu = TopicOf(reader, file, imu_topic, {ros::Imu::kType}, "rates", unsaid);
  if (!imu) return std::nullopt;
  const std::string camera_frame = FrameOf(reader, image_topic), imu_frame = FrameOf(reader, *imu);
  if (camera_frame.empty() || imu_frame.empty()) return std::nullopt;
  const Frames frames = FramesOf(reader);
  const std::map<std::string, Pose> above_camera = PosesAbove(frames, camera_frame);
  // Up from the IMU, until a frame that is above the camera too: what moves is above both.
  Pose X_FI{Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()};
  std::string frame = imu_frame;
  for (std::size_t step = 0; step <= frames.size(); ++step) {
    if (const auto common = above_camera.find(frame); common != above_camera.end())
      return X_FI.Inverse() * common->second;
    const auto joined = frames.find(frame);
    if (joined == frames.end()) return std::nullopt;
    X_FI = joined->second.X * X_FI, frame = joined->second.parent;
  }
  return std::nullopt;
}

}  // namespace kestrel::vision
