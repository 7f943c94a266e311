// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/images_input.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "records/video/video_reader.h"
#include "vision/capture/camera_address.h"
#include "vision/capture/folder_source.h"
#include "vision/capture/live_camera.h"
#include "vision/interlaced.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

void RefuseOtherSizes(const std::string& file, const cv::Size& size, Mistakes& mistakes) {
  try {
    if (const auto other = records::OtherSizeIn(file, size))
      mistakes.Add(
          file, "",
          fmt::format("its images change from {} x {} to {} x {} pixels, and a calibration is of one size",
                      size.width, size.height, other->width, other->height),
          "valid: the parts by themselves; ffmpeg -ss and -to to cut them out");
  } catch (const std::runtime_error& e) {
    mistakes.Add(file, "", fmt::format("neither an image nor a video: {}", e.what()));
  }
}

// Where images do not come evenly, or not at the rate that the file gives: their own times, and the rate of them all.
void TakeTimes(const std::string& file, ImageInput& input) {
  std::vector<double> times_s = records::ImageTimesIn(file);
  if (times_s.size() < 3 || !(times_s.back() > 0)) return;
  std::vector<double> steps_s(times_s.size());
  std::adjacent_difference(times_s.begin(), times_s.end(), steps_s.begin());
  const auto [least, most] = std::minmax_element(steps_s.begin() + 1, steps_s.end());
  constexpr double kEven = 0.3;  // of the step: what stamps in whole milliseconds leave uneven
  const double even_s = 1 / input.rate_hz;
  if (std::max(even_s - *least, *most - even_s) <= kEven * even_s) return;
  input.rate_hz = static_cast<double>(times_s.size() - 1) / times_s.back();
  input.note += fmt::format(
      "{}the images come {:.3f} to {:.3f} s apart, {:.3g} a second in the mean; ffmpeg -i {} -vf fps={:.3g} "
      "EVEN.mp4 "
      "makes them come evenly",
      input.note.empty() ? "" : "\n", *least, *most, input.rate_hz, file, 1 / std::max(*least, 1e-3));
  input.next = [next = std::move(input.next), times_s = std::move(times_s), number = std::size_t{0},
                rate = input.rate_hz]() mutable -> std::optional<vision::Frame> {
    auto frame = next();
    if (!frame) return frame;
    const std::size_t i = number++, last = times_s.size() - 1;
    frame->t_s = times_s[std::min(i, last)] + static_cast<double>(i - std::min(i, last)) / rate;
    return frame;
  };
}

ImageInput LiveInput(const std::string& address, const std::atomic<bool>& stopped, Mistakes& mistakes) {
  ImageInput input;
  try {
    const vision::CameraAddress parsed = vision::ParseCameraAddress(address);
    const cv::Size size = vision::SizeAt(parsed);
    if (!size.empty()) input.size = size;
    const auto camera =
        std::make_shared<vision::LiveCamera>(vision::SourceAt(parsed), vision::LiveCameraOptions{});
    input.next = [camera, &stopped]() -> std::optional<vision::Frame> {
      constexpr double kLook_s = 0.2;  // how long an interrupt may wait
      while (!stopped) {
        if (auto frame = camera->Next(kLook_s)) return frame;
        if (camera->Health().state == vision::LiveCameraState::kEnded) break;
      }
      return std::nullopt;
    };
  } catch (const InputError& e) {
    mistakes.Add(e);
  }
  return input;
}

ImageInput FolderInput(const ImageArguments& a, Mistakes& mistakes) {
  ImageInput input;
  const auto make = vision::FolderSource({.images = a.input, .size = {}, .colour = true, .bits = a.bits});
  const std::unique_ptr<vision::ImageSource> ahead = make();
  auto first = ahead->Open() ? ahead->Grab() : std::nullopt;
  const std::string error = ahead->Error();
  while (!first && !ahead->Error().empty()) first = ahead->Grab();
  if (!first) {
    mistakes.Add(a.input, "", error, "valid: a folder of images, by name in the order of time");
    return input;
  }
  input.size = first->image.size();
  const std::shared_ptr<vision::ImageSource> folder = make();
  folder->Open();
  input.next = [folder, number = 0, rate = input.rate_hz]() mutable -> std::optional<vision::Frame> {
    const auto image = folder->Grab();
    if (!image && folder->Error().empty()) return std::nullopt;
    const int i = number++;
    if (!image) throw UnreadableImage(folder->Error(), i / rate);
    return vision::Frame{image->image, i / rate, i};
  };
  return input;
}

ImageInput Open(const ImageArguments& a, const std::atomic<bool>& stopped, Mistakes& mistakes) {
  std::error_code none;
  if (!fs::exists(a.input, none) && a.input.find(':') != std::string::npos)
    return LiveInput(a.input, stopped, mistakes);
  if (fs::is_directory(a.input, none)) return FolderInput(a, mistakes);
  ImageInput input = OpenImageFile(a, mistakes);
  if (input.still || !input.size) return input;
  RefuseOtherSizes(a.input, *input.size, mistakes);
  TakeTimes(a.input, input);
  return input;
}

}  // namespace

void AddDeinterlaceOption(CLI::App& command, ImageArguments& a) {
  command.add_flag("--deinterlace", a.deinterlace,
                   "Of interlaced video: take every other row, and draw those between from them");
}

ImageInput OpenImages(const ImageArguments& a, const std::atomic<bool>& stopped, Mistakes& mistakes) {
  ImageInput input = Open(a, stopped, mistakes);
  if (!a.deinterlace) return input;
  input.next = [next = std::move(input.next)]() -> std::optional<vision::Frame> {
    auto frame = next();
    if (frame) frame->image = vision::FirstField(frame->image);
    return frame;
  };
  return input;
}

std::optional<vision::Frame> NextImage(ImageInput& input, int number, bool quiet) {
  try {
    return input.next();
  } catch (const UnreadableImage& e) {
    if (!quiet) fmt::print("unreadable: {}\n", e.what());
    return vision::Frame{{}, e.t_s, number};
  }
}

}  // namespace kestrel::app
