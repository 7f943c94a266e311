// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/images/event_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <stdexcept>

#include "base/nanoseconds.h"
#include "vision/write_image.h"

namespace kestrel::flight {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kShown_ns = 10'000'000;
const cv::Vec3b kBrighter(0, 0, 255), kDarker(255, 0, 0);

const fs::path& Cleared(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", folder.string(), error.message()));
  static const std::regex ours(R"((events\.txt|\d{6,}_events\.png)(\.part)?)");
  for (const auto& entry : fs::directory_iterator(folder))
    if (std::regex_match(entry.path().filename().string(), ours)) fs::remove(entry.path());
  return folder;
}

}  // namespace

EventFiles::EventFiles(const fs::path& folder) : folder_(Cleared(folder)), file_(folder / "events.txt") {}

void EventFiles::Write(const std::vector<sim::Event>& events) {
  std::string lines;
  for (const sim::Event& e : events)
    fmt::format_to(std::back_inserter(lines), "{}.{:09} {} {} {:d}\n", e.t_ns / kSecond_ns,
                   e.t_ns % kSecond_ns, e.x, e.y, e.on);
  file_.Write(lines);
  recent_.insert(recent_.end(), events.begin(), events.end());
}

void EventFiles::WriteView(std::int64_t sequence, double t_s, const cv::Mat& frame) {
  const std::int64_t until_ns = Nanoseconds(t_s);
  while (!recent_.empty() && recent_.front().t_ns <= until_ns - kShown_ns) recent_.pop_front();
  cv::Mat view;
  if (frame.channels() == 1)
    cv::cvtColor(frame, view, cv::COLOR_GRAY2BGR);
  else
    view = frame.clone();
  for (const sim::Event& e : recent_)
    if (e.t_ns <= until_ns) view.at<cv::Vec3b>(e.y, e.x) = e.on ? kBrighter : kDarker;
  vision::WriteImage(folder_ / fmt::format("{:06}_events.png", sequence), view);
}

void EventFiles::Close() { file_.Close(); }

}  // namespace kestrel::flight
