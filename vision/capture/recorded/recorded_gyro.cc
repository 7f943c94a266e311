// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/recorded_gyro.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "base/mcap/reader.h"
#include "base/ros/cdr.h"
#include "base/ros/sensor_messages.h"
#include "base/user_file.h"
#include "vision/capture/recorded/mcap_images.h"
#include "vision/capture/recorded/mcap_topic.h"
#include "vision/capture/recorded/stamp.h"
#include "vision/capture/recorded/stamped_table.h"

namespace kestrel::vision {
namespace {

constexpr std::size_t kRateCells = 4;  // and the specific force, which is not read
constexpr const char* kImuRow =
    "rows of a stamp in ns, the rates in rad/s and the specific force, between commas";

bool IsEurocImu(const std::filesystem::path& file) {
  if (!IsFile(file)) return false;
  constexpr std::size_t kHeader = 256;  // as much of it as tells
  std::string begin(kHeader, '\0');
  std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  const std::string_view header = std::string_view(begin).substr(0, begin.find('\n'));
  return header.starts_with("#timestamp") && header.find("rad") != std::string_view::npos;
}

std::vector<RecordedRate> ReadEurocImu(const std::filesystem::path& file, Mistakes& mistakes) {
  std::vector<RecordedRate> rates;
  const auto row = [&](std::int64_t stamp_ns, const std::vector<std::string>& cells) -> std::string {
    RecordedRate rate{stamp_ns, {}};
    for (std::size_t i = 1; i < kRateCells; ++i) {
      double& value = rate.w_I[static_cast<int>(i) - 1];
      const auto [end, error] = std::from_chars(cells[i].data(), cells[i].data() + cells[i].size(), value);
      if (error != std::errc() || end != cells[i].data() + cells[i].size() || !std::isfinite(value))
        return fmt::format("'{:.80}' is no rate", cells[i]);
    }
    rates.push_back(rate);
    return "";
  };
  ReadTable(file,
            {.between = ',',
             .least_cells = kRateCells,
             .most_cells = 7,
             .stamp = StampOfNanoseconds,
             .row = kImuRow},
            mistakes, row);
  return rates;
}

std::vector<RecordedRate> ReadMcapImu(const std::filesystem::path& file, const std::string& given,
                                      Mistakes& mistakes) {
  mcap::Reader reader(file);
  const auto topic = TopicOf(reader, file, given, {ros::Imu::kType}, "rates", mistakes);
  if (!topic) return {};
  McapStamps stamps(file, *topic, mistakes);
  std::vector<RecordedRate> rates;
  reader.Select({*topic});
  while (const auto message = reader.Next()) {
    stamps.Add(*message);
    RecordedRate& rate = rates.emplace_back();
    try {
      const ros::Vector3 w = ros::FromCdr<ros::Imu>(message->data).angular_velocity;
      rate.w_I = {w.x, w.y, w.z};
      if (!rate.w_I.allFinite()) stamps.Wrong("has a rate that is no number");
    } catch (const ros::CdrError& e) {
      stamps.Wrong(e.what());
    }
  }
  const std::vector<std::int64_t> stamps_ns = stamps.Take();
  for (std::size_t i = 0; i < rates.size(); ++i) rates[i].stamp_ns = stamps_ns[i];
  return rates;
}

}  // namespace

bool IsRecordedGyro(const std::filesystem::path& file) { return IsEurocImu(file) || IsMcap(file); }

std::vector<RecordedRate> ReadRecordedGyro(const std::filesystem::path& file, const std::string& topic,
                                           Mistakes& mistakes) {
  const std::size_t before = mistakes.all().size();
  std::vector<RecordedRate> rates;
  try {
    rates = IsMcap(file) ? ReadMcapImu(file, topic, mistakes) : ReadEurocImu(file, mistakes);
  } catch (const InputError& e) {
    mistakes.Add(e);
  }
  if (mistakes.all().size() == before && rates.size() < 2)
    mistakes.Add(file.string(), "", fmt::format("it has {} samples of a gyro", rates.size()),
                 "valid: two or more");
  return mistakes.all().size() > before ? std::vector<RecordedRate>() : rates;
}

}  // namespace kestrel::vision
