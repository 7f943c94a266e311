// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/mcap/writer.h"
#include "base/nanoseconds.h"
#include "base/ros/cdr.h"
#include "base/ros/schemas.h"
#include "mission/log_row.h"
#include "vision/camera.h"
#include "vision/camera/camera_model.h"

namespace kestrel::records {

enum class McapImages { kJpeg, kRaw };

struct FlightMcapOptions {
  McapImages images = McapImages::kJpeg;
  bool truth = true;                     // is known
  std::vector<Eigen::Vector2d> outline;  // of the pad, in its plane, m; empty: there is none
  vision::CameraModel camera;            // by which the flight is flown, as its code believes it to be
  Pose X_BC;                             // the same
};

// flight.mcap: a flight as ROS's and Foxglove's tools read it (docs/guide/logs.md has the topics). Log times
// are those at which the flight code had a message, stamps those that it is of, both in ns of the flight's
// time.
//
// Throws std::runtime_error with the file and the reason.
class FlightMcap {
 public:
  FlightMcap(const std::filesystem::path& file, FlightMcapOptions options);

  // scenario.yaml, and what else a reader may want to know of the flight.
  void WriteScenario(const std::string& yaml, const std::map<std::string, std::string>& about);

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
    WriteCdr(topic, Message::kType, log_time_ns, stamp_ns, ros::ToCdr(message));
  }

  void Close() { writer_.Close(); }

 private:
  void WriteCdr(const std::string& topic, const char* type, std::int64_t log_time_ns, std::int64_t stamp_ns,
                const std::string& cdr);
  void WriteImage(const std::string& camera, const vision::CameraModel& model, const cv::Mat& image,
                  double stamp_s, double came_s);

  FlightMcapOptions options_;
  mcap::Writer writer_;
  std::map<std::string, std::uint16_t> channels_;  // by topic
};

}  // namespace kestrel::records
