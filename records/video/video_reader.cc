// SPDX-License-Identifier: Apache-2.0
#include "records/video/video_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "vision/image_file.h"

namespace kestrel::records {
namespace {

template <class Action>
auto Named(const std::filesystem::path& file, Action action) {
  try {
    return action();
  } catch (const std::exception& e) {
    throw std::runtime_error(fmt::format("cannot read {} as a video: {}", file.string(), e.what()));
  }
}

std::string OutputOf(std::vector<std::string> command) {
  PipedProcess program(std::move(command), PipedProcess::Direction::kRead);
  std::string output(1 << 16, '\0');
  output.resize(program.Read(output.data(), output.size()));
  program.Close();
  return output;
}

// What ffprobe says of the video's frames or packets, a line each.
std::string LinesOf(std::vector<std::string> what, const std::filesystem::path& file) {
  std::vector<std::string> command = {"ffprobe", "-loglevel", "quiet", "-select_streams", "v:0"};
  command.insert(command.end(), what.begin(), what.end());
  command.insert(command.end(), {"-of", "csv=print_section=0", "file:" + file.string()});
  PipedProcess program(std::move(command), PipedProcess::Direction::kRead);
  std::string text;
  char part[4096];
  while (const std::size_t got = program.Read(part, sizeof part)) text.append(part, got);
  return text;
}

// ffprobe writes numbers as text, "N/A" where it has none, and rates as fractions.
double NumberOf(const nlohmann::json& object, const char* key) {
  const std::string text = object.value(key, "");
  const std::size_t slash = text.find('/');
  const auto number = [](std::string_view s) {
    double value = 0;
    std::from_chars(s.data(), s.data() + s.size(), value);
    return value;
  };
  if (slash == std::string::npos) return number(text);
  const double below = number(std::string_view(text).substr(slash + 1));
  return below > 0 ? number(std::string_view(text).substr(0, slash)) / below : 0;
}

}  // namespace

VideoReader::VideoReader(std::filesystem::path file) : file_(std::move(file)) {
  Named(file_, [&] {
    const nlohmann::json found = nlohmann::json::parse(
        OutputOf({"ffprobe", "-loglevel", "error", "-select_streams", "v:0", "-show_entries",
                  "stream=width,height,avg_frame_rate,nb_frames:format=duration", "-of", "json",
                  "file:" + file_.string()}));
    if (!found.contains("streams") || found["streams"].empty())
      throw std::runtime_error("there is no video in it");
    const nlohmann::json& stream = found["streams"][0];
    size_ = {stream.value("width", 0), stream.value("height", 0)};
    if (size_.empty()) throw std::runtime_error("its images have no size");
    if (std::max(size_.width, size_.height) > vision::kMaxImageSide_px)
      throw std::runtime_error(fmt::format("its images have {} x {} pixels; valid: up to {} x {}",
                                           size_.width, size_.height, vision::kMaxImageSide_px,
                                           vision::kMaxImageSide_px));
    rate_hz_ = NumberOf(stream, "avg_frame_rate");
    if (!(rate_hz_ > 0)) rate_hz_ = 25;  // a still image, or a file that does not say
    frames_ = NumberOf(stream, "nb_frames");
    if (!(frames_ > 0))
      frames_ = std::round(NumberOf(found.value("format", nlohmann::json::object()), "duration") * rate_hz_);
    // Every frame once, whatever their times; and without accurate rounding the colours come out two levels
    // too dark.
    ffmpeg_.emplace(
        std::vector<std::string>{"ffmpeg", "-nostdin", "-loglevel", "error", "-noautorotate", "-i",
                                 "file:" + file_.string(), "-map", "0:v:0", "-fps_mode", "passthrough",
                                 "-sws_flags", "bicubic+accurate_rnd+full_chroma_int", "-f", "rawvideo",
                                 "-pix_fmt", "bgr24", "pipe:1"},
        PipedProcess::Direction::kRead);
  });
}

std::optional<cv::Mat> VideoReader::Next() {
  if (!ffmpeg_) return std::nullopt;
  return Named(file_, [&]() -> std::optional<cv::Mat> {
    cv::Mat bgr(size_, CV_8UC3);
    const std::size_t bytes = bgr.total() * bgr.elemSize();
    const std::size_t got = ffmpeg_->Read(bgr.ptr<char>(), bytes);
    if (got == bytes) return bgr;
    ffmpeg_->Close();
    ffmpeg_.reset();
    if (got > 0) throw std::runtime_error("it breaks off within a frame");
    return std::nullopt;
  });
}

std::optional<cv::Size> OtherSizeIn(const std::filesystem::path& file, const cv::Size& size) {
  return Named(file, [&]() -> std::optional<cv::Size> {
    std::istringstream lines(LinesOf({"-skip_frame", "nokey", "-show_entries", "frame=width,height"}, file));
    for (std::string line; std::getline(lines, line);) {
      cv::Size other;
      if (std::sscanf(line.c_str(), "%d,%d", &other.width, &other.height) == 2 && other != size) return other;
    }
    return std::nullopt;
  });
}

std::vector<double> ImageTimesIn(const std::filesystem::path& file) {
  return Named(file, [&]() -> std::vector<double> {
    std::istringstream lines(LinesOf({"-show_entries", "packet=pts_time,flags"}, file));
    std::vector<double> times_s;
    for (std::string line; std::getline(lines, line);) {
      const std::size_t comma = line.find(',');
      if (comma != std::string::npos && line.find('D', comma) != std::string::npos) continue;  // never shown
      double t_s = 0;
      if (std::sscanf(line.c_str(), "%lf", &t_s) != 1) return {};
      times_s.push_back(t_s);
    }
    std::sort(times_s.begin(), times_s.end());  // packets come as they are decoded
    for (std::size_t i = times_s.size(); i-- > 0;) times_s[i] -= times_s[0];
    return times_s;
  });
}

}  // namespace kestrel::records
