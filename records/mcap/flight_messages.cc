// SPDX-License-Identifier: Apache-2.0
#include "records/mcap/flight_messages.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <variant>

#include "base/nanoseconds.h"
#include "base/ros/sensor_messages.h"
#include "geometry/ros_frames.h"
#include "records/mcap/camera_info.h"
#include "records/mcap/row_messages.h"

namespace kestrel::records {
namespace {

constexpr char kMainCamera[] = "main";
constexpr int kJpegQuality = 90;

std::string FrameOf(const std::string& camera) { return "camera_" + camera; }

ros::Image RawImageOf(const cv::Mat& image) {
  ros::Image message;
  message.height = static_cast<std::uint32_t>(image.rows);
  message.width = static_cast<std::uint32_t>(image.cols);
  message.encoding = image.channels() == 3 ? "bgr8" : "mono8";
  message.step = static_cast<std::uint32_t>(image.cols * image.elemSize());
  message.data.resize(std::size_t{message.step} * message.height);
  for (int row = 0; row < image.rows; ++row)
    std::copy_n(image.ptr(row), message.step,
                &message.data[std::size_t{message.step} * static_cast<std::size_t>(row)]);
  return message;
}

}  // namespace

void FlightMessages::WriteImage(const std::string& camera, const vision::CameraModel& model,
                                const cv::Mat& image, double stamp_s, double came_s) {
  const std::int64_t came_ns = Nanoseconds(came_s), stamp_ns = Nanoseconds(stamp_s);
  const std::string topic = "/camera/" + camera;
  const ros::Header header{ros::TimeOf(stamp_ns), FrameOf(camera)};
  ros::CameraInfo info = CameraInfoOf(model);
  info.header = header;
  Write(topic + "/camera_info", came_ns, stamp_ns, info);
  if (options_.images == McapImages::kRaw) {
    ros::Image raw = RawImageOf(image);
    raw.header = header;
    Write(topic + "/image_raw", came_ns, stamp_ns, raw);
  } else if (Wants(topic + "/image_raw/compressed", ros::CompressedImage::kType)) {
    ros::CompressedImage jpeg{header, "jpeg", {}};
    if (!cv::imencode(".jpg", image, jpeg.data, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}))
      throw std::runtime_error("cannot write an image as JPEG");
    Write(topic + "/image_raw/compressed", came_ns, stamp_ns, jpeg);
  }
}

void FlightMessages::Write(const mission::LogRow& row, const cv::Mat& image) {
  const std::int64_t now = Nanoseconds(row.now.t_s), exposed = Nanoseconds(row.exposure.t_s);
  if (options_.truth) {
    Write("/truth", now, now, TruthMessage(row.now));
    Write("/tf", now, exposed, TfMessageOf(row.exposure, FrameOf(kMainCamera)));
    Write("/wind", now, now, WindMessage(row.now));
  }
  if (row.heard) Write("/estimate", now, Nanoseconds(row.estimate.t_s), EstimateMessage(row.estimate));
  if (!image.empty()) {
    WriteImage(kMainCamera, options_.camera, image, row.exposure.t_s, row.now.t_s);
    const ros::ImageAnnotations drawn = DrawnMessage(row, options_.outline, options_.camera, options_.X_BC);
    Write("/camera/main/annotations", now, exposed, drawn);
  }
  if (const auto fix = FixMessage(row)) Write("/fix", now, exposed, *fix);
  if (const auto goal = GoalMessage(row)) Write("/goal", now, now, *goal);
  if (!row.decision.setpoint) return;
  const SetpointMessage setpoint = SetpointMessageOf(*row.decision.setpoint, row.estimate);
  constexpr const char* kTopics[] = {"/setpoint/velocity", "/setpoint/position", "/setpoint/attitude"};
  std::visit([&](const auto& is) { Write(kTopics[setpoint.index()], now, now, is); }, setpoint);
}

void FlightMessages::WriteFrame(const std::string& camera, const vision::CameraModel& model, const Pose& X_BC,
                                const vision::Frame& frame, double came_s) {
  WriteImage(camera, model, frame.image, frame.t_s, came_s);
  ros::TfMessage tf;
  tf.transforms.push_back(
      {HeaderOf(frame.t_s, kBodyFrame), FrameOf(camera), TransformOf(BodyCameraToRos(X_BC))});
  Write("/tf", Nanoseconds(came_s), Nanoseconds(frame.t_s), tf);
}

void FlightMessages::WriteEvent(double t_s, std::string_view what, std::string_view is) {
  ros::Log log;
  log.stamp = HeaderOf(t_s, "").stamp;
  log.name = what;
  log.msg = is;
  Write("/events", Nanoseconds(t_s), Nanoseconds(t_s), log);
}

}  // namespace kestrel::records
