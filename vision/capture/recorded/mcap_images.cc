// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/mcap_images.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <optional>
#include <vector>

#include "base/mcap/reader.h"
#include "base/mcap/wire.h"
#include "base/ros/cdr.h"
#include "base/ros/sensor_messages.h"
#include "base/user_file.h"
#include "vision/capture/recorded/mcap_topic.h"
#include "vision/capture/recorded/raw_image.h"

namespace kestrel::vision {
namespace {

namespace fs = std::filesystem;

ImageFile Decoded(const mcap::Message& message, ImageColours colours) {
  try {
    if (message.channel->schema.name == ros::Image::kType) {
      const auto image = ros::FromCdr<ros::Image>(message.data);
      return DecodeRawImage({.width_px = image.width,
                             .height_px = image.height,
                             .step = image.step,
                             .encoding = image.encoding,
                             .big_endian = image.is_bigendian != 0,
                             .data = {reinterpret_cast<const char*>(image.data.data()), image.data.size()}},
                            colours);
    }
    const auto image = ros::FromCdr<ros::CompressedImage>(message.data);
    if (image.format.find("compressedDepth") != std::string::npos)
      return {{}, {}, fmt::format("has the format '{}'; valid: jpeg or png", image.format)};
    return DecodeImage({image.data.begin(), image.data.end()}, colours);
  } catch (const ros::CdrError& e) {
    return {{}, {}, e.what()};
  }
}

// Reads in the order of the log; one that came before, from its beginning.
class InOrder {
 public:
  InOrder(const fs::path& file, const std::string& topic) : reader_(file), topic_({topic}) {
    reader_.Select(topic_);
  }
  ImageFile Read(std::size_t index, ImageColours colours) {
    if (index < next_) reader_.Select(topic_), next_ = 0;
    std::optional<mcap::Message> message;
    do message = reader_.Next();
    while (message && next_++ < index);
    return message ? Decoded(*message, colours) : ImageFile{{}, {}, "is not in the file any more"};
  }

 private:
  mcap::Reader reader_;
  std::vector<std::string> topic_;
  std::size_t next_ = 0;
};

// The topic of the camera_info that goes with one of images, as image_transport has them.
std::string InfoOf(std::string topic) {
  if (topic.ends_with("/compressed")) topic.resize(topic.rfind('/'));
  return topic.substr(0, topic.rfind('/') + 1) + "camera_info";
}

// The first camera_info, as ROS prints it; empty: there is none, or it is not calibrated.
std::string CalibrationOf(mcap::Reader& reader, const std::string& topic) {
  const std::vector<std::string> infos = TopicsOf(reader, {ros::CameraInfo::kType});
  const std::string wanted = InfoOf(topic);
  if (std::find(infos.begin(), infos.end(), wanted) == infos.end()) return "";
  reader.Select({wanted});
  const auto message = reader.Next();
  if (!message) return "";
  try {
    const auto info = ros::FromCdr<ros::CameraInfo>(message->data);
    if (info.k[0] == 0) return "";
    return fmt::format("image_width: {}\nimage_height: {}\ndistortion_model: {}\nD: [{}]\nK: [{}]\n",
                       info.width, info.height, info.distortion_model, fmt::join(info.d, ", "),
                       fmt::join(info.k, ", "));
  } catch (const ros::CdrError&) {
    return "";
  }
}

RecordedImages FromMcap(const fs::path& file, const std::string& given, Mistakes& mistakes) {
  mcap::Reader reader(file);
  const auto topic =
      TopicOf(reader, file, given, {ros::Image::kType, ros::CompressedImage::kType}, "images", mistakes);
  if (!topic) return {};
  McapStamps stamps(file, *topic, mistakes);
  RecordedImages recorded;
  reader.Select({*topic});
  while (const auto message = reader.Next()) {
    recorded.names.push_back(stamps.NameOf(recorded.names.size()));
    stamps.Add(*message);
  }
  if (recorded.names.empty())
    mistakes.Add(file.string(), "topic",
                 fmt::format("{} has no messages{}", *topic,
                             reader.damage().empty() ? "" : " that are whole: " + reader.damage()),
                 "valid: a topic with images");
  recorded.stamps_ns = stamps.Take();
  recorded.logged_ns = stamps.logged_ns();
  recorded.note = stamps.Note(reader, "images");
  recorded.topic = *topic;
  recorded.calibration_text = CalibrationOf(reader, *topic);
  if (!TopicsOf(reader, {ros::Imu::kType}).empty()) recorded.gyro = file;
  recorded.reader = [file, topic = *topic]() -> RecordedImages::Reader {
    const auto in_order = std::make_shared<InOrder>(file, topic);
    return [in_order](std::size_t i, ImageColours colours) { return in_order->Read(i, colours); };
  };
  return recorded;
}

}  // namespace

bool IsMcap(const fs::path& file) {
  if (!IsFile(file)) return false;
  std::string begin(mcap::kMagic.size(), '\0');
  std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin == mcap::kMagic || file.extension() == ".mcap";
}

RecordedImages OpenMcapImages(const fs::path& file, const std::string& topic, Mistakes& mistakes) {
  try {
    return FromMcap(file, topic, mistakes);
  } catch (const InputError& e) {
    mistakes.Add(e);
    return {};
  }
}

}  // namespace kestrel::vision
