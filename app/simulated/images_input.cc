// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/images_input.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

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
  if (!input.still && input.size) RefuseOtherSizes(a.input, *input.size, mistakes);
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

}  // namespace kestrel::app
