// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/ros/cdr.h"
#include "mission/log_row.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"

namespace kestrel::records {

enum class McapImages { kJpeg, kRaw };

struct FlightMessageOptions {
  McapImages images = McapImages::kJpeg;
  bool truth = true;                     // is known
  std::vector<Eigen::Vector2d> outline;  // of the pad, in its plane, m; empty: there is none
  vision::CameraModel camera;            // by which the flight is flown, as its code believes it to be
  Pose X_BC;                             // the same
};

// A flight as messages of ROS 2, by topic (docs/guide/logs.md has them), for a file or for who watches. Log
// times are those at which the flight code had a message, stamps those that it is of, both in ns of the
// flight's time.
class FlightMessages {
 public:
  explicit FlightMessages(FlightMessageOptions options) : options_(std::move(options)) {}
  virtual ~FlightMessages() = default;

  // A frame of the camera that the flight is flown by, and what was made of it. image: empty: there is none.
  void Write(const mission::LogRow& row, const cv::Mat& image);
  // Of a camera beside it: where it is on the aircraft goes to /tf.
  void WriteFrame(const std::string& camera, const vision::CameraModel& model, const Pose& X_BC,
                  const vision::Frame& frame, double came_s);
  void WriteEvent(double t_s, std::string_view what, std::string_view is);
  // Anything else.
  template <class Message>
  void Write(const std::string& topic, std::int64_t log_time_ns, std::int64_t stamp_ns,
             const Message& message) {
    if (Wants(topic, Message::kType))
      WriteCdr(topic, Message::kType, log_time_ns, stamp_ns, ros::ToCdr(message));
  }

 private:
  // Whether a message of this topic is to be made at all.
  virtual bool Wants(const std::string& topic, const char* type) = 0;
  virtual void WriteCdr(const std::string& topic, const char* type, std::int64_t log_time_ns,
                        std::int64_t stamp_ns, const std::string& cdr) = 0;
  void WriteImage(const std::string& camera, const vision::CameraModel& model, const cv::Mat& image,
                  double stamp_s, double came_s);

  FlightMessageOptions options_;
};

}  // namespace kestrel::records
