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
#include <variant>
#include <vector>

#include "app/option/within.h"
#include "records/video/video_reader.h"
#include "vision/capture/camera_address.h"
#include "vision/capture/folder_source.h"
#include "vision/capture/live_camera.h"
#include "vision/capture/recorded/recorded_images.h"
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

ImageInput LiveInput(const vision::CameraAddress& address, const std::atomic<bool>& stopped) {
  ImageInput input;
  const cv::Size size = vision::SizeAt(address);
  if (!size.empty()) input.size = size;
  const auto camera =
      std::make_shared<vision::LiveCamera>(vision::SourceAt(address), vision::LiveCameraOptions{});
  input.next = [camera, &stopped]() -> std::optional<vision::Frame> {
    constexpr double kLook_s = 0.2;  // how long an interrupt may wait
    while (!stopped) {
      if (auto frame = camera->Next(kLook_s)) return frame;
      if (camera->Health().state == vision::LiveCameraState::kEnded) break;
    }
    return std::nullopt;
  };
  return input;
}

// Of a recording with stamps, from when they are, and how they follow one another.
std::string NoteOfStamps(const vision::RecordedImages& recorded) {
  return fmt::format(
      "{} images{}, stamped from {} ns, {:.9g} s, {:.4g} a second in the mean; t_s counts from there",
      recorded.size(), recorded.topic.empty() ? "" : " of " + recorded.topic, recorded.stamps_ns.front(),
      recorded.Time_s(recorded.size() - 1), recorded.Rate_hz());
}

ImageInput RecordedInput(const ImageArguments& a, vision::FolderSourceOptions options, Mistakes& mistakes) {
  ImageInput input;
  const std::size_t before = mistakes.all().size();
  if (!options.opened)
    options.opened = std::make_shared<const vision::RecordedImages>(
        vision::OpenRecordedImages(options.images, options.topic, mistakes));
  if (mistakes.all().size() > before) return input;
  const auto& recorded = options.opened;
  const auto make = vision::FolderSource(options);
  const std::unique_ptr<vision::ImageSource> ahead = make();
  auto first = ahead->Open() ? ahead->Grab() : std::nullopt;
  const std::string error = ahead->Error();
  while (!first && !ahead->Error().empty()) first = ahead->Grab();
  if (!first) {
    mistakes.Add(a.input, "", error,
                 "valid: a folder of images, by name in the order of time, or a recording");
    return input;
  }
  if (recorded->stamped() && a.rate_hz)
    mistakes.Add("--rate", "", fmt::format("{:g}, and the images have stamps of their own", *a.rate_hz),
                 "valid: without it");
  input.size = first->image.size();
  input.rate_hz = a.rate_hz.value_or(input.rate_hz);
  input.calibration = recorded->calibration, input.gyro = recorded->gyro, input.topic = recorded->topic;
  input.calibration_text = recorded->calibration_text;
  input.note = recorded->note;
  if (recorded->stamped()) {
    if (recorded->Rate_hz() > 0) input.rate_hz = recorded->Rate_hz();
    input.first_ns = recorded->stamps_ns.front();
    input.note += (input.note.empty() ? "" : "\n") + NoteOfStamps(*recorded);
  }
  const std::shared_ptr<vision::ImageSource> source = make();
  source->Open();
  input.next = [source, recorded, number = std::size_t{0},
                rate = input.rate_hz]() mutable -> std::optional<vision::Frame> {
    const auto image = source->Grab();
    if (!image && source->Error().empty()) return std::nullopt;
    const std::size_t i = number++;
    const double t_s = recorded->stamped() ? recorded->Time_s(i) : static_cast<double>(i) / rate;
    if (!image) throw UnreadableImage(source->Error(), t_s);
    return vision::Frame{image->image, t_s, static_cast<std::int64_t>(i)};
  };
  return input;
}

void RefuseRecordingOptions(const ImageArguments& a, const std::string& why, const std::string& remedy,
                            Mistakes& mistakes) {
  for (const auto& [option, given] :
       {std::pair{"--topic", !a.topic.empty()}, {"--rate", a.rate_hz.has_value()}})
    if (given) mistakes.Add(option, "", why, remedy);
}

ImageInput AddressInput(const ImageArguments& a, const std::atomic<bool>& stopped, Mistakes& mistakes) {
  RefuseRecordingOptions(a, "with a camera's address, which has options of its own",
                         "valid: ?topic=NAME&rate=HZ after it", mistakes);
  try {
    const vision::CameraAddress address = vision::ParseCameraAddress(a.input);
    const auto* recording = std::get_if<vision::FolderSourceOptions>(&address);
    if (!recording) return LiveInput(address, stopped);
    ImageArguments as_given = a;
    if (recording->rate_hz > 0) as_given.rate_hz = recording->rate_hz;
    vision::FolderSourceOptions at_once = *recording;  // a verb waits for none of its images
    at_once.as_recorded = false, at_once.rate_hz = 0, at_once.colour = true;
    if (a.bits) at_once.bits = a.bits;
    return RecordedInput(as_given, at_once, mistakes);
  } catch (const InputError& e) {
    mistakes.Add(e);
    return {};
  }
}

ImageInput Open(const ImageArguments& a, const std::atomic<bool>& stopped, Mistakes& mistakes) {
  std::error_code none;
  if (!fs::exists(a.input, none) && a.input.find(':') != std::string::npos)
    return AddressInput(a, stopped, mistakes);
  if (vision::IsRecording(a.input))
    return RecordedInput(a, {.images = a.input, .topic = a.topic, .size = {}, .colour = true, .bits = a.bits},
                         mistakes);
  RefuseRecordingOptions(a, fmt::format("'{}' is no recording", a.input),
                         "valid: with a folder of images, a data set or an MCAP", mistakes);
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

void AddRecordingOptions(CLI::App& command, ImageArguments& a) {
  command
      .add_option("--topic", a.topic,
                  "Which camera of a recording with several, by its folder or topic, as cam1 or "
                  "/camera/image_raw (default: the only one, or cam0)")
      ->type_name("NAME");
  command
      .add_option("--rate", a.rate_hz, "How many a second are a folder's images without stamps (default: 25)")
      ->check(Within(0.01, 10000.0));
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
