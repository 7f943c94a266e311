// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/track_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "app/option/bits_option.h"
#include "app/simulated/tracked.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/process/end_signals.h"
#include "base/stopwatch.h"
#include "base/user_file.h"
#include "mission/helipad_pilot.h"
#include "records/video/video.h"
#include "records/video/video_reader.h"
#include "vision/camera/calibration_file.h"
#include "vision/capture/camera_address.h"
#include "vision/capture/live_camera.h"
#include "vision/image_file.h"
#include "vision/landmark/pad_file.h"
#include "vision/write_image.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> stopped = false;

// Where images come from, one after the other.
struct Input {
  std::optional<cv::Size> size;  // none: a camera, of which only an image tells
  double rate_hz = 25;
  bool still = false;
  std::function<std::optional<vision::Frame>()> next;
  std::string note;
};

Input StillInput(const TrackArguments& a, Mistakes& mistakes) {
  Input input;
  input.still = true;
  const cv::Mat image =
      vision::ReadImage(a.input, vision::ImageColours::kColour, a.bits, mistakes, input.note);
  if (!image.empty()) input.size = image.size();
  input.next = [image, given = false]() mutable -> std::optional<vision::Frame> {
    if (std::exchange(given, true)) return std::nullopt;
    return vision::Frame{image, 0, 0};
  };
  return input;
}

Input VideoInput(const std::string& file, Mistakes& mistakes) {
  Input input;
  try {
    const auto reader = std::make_shared<records::VideoReader>(file);
    input.size = reader->size();
    input.rate_hz = reader->rate_hz();
    if (const auto other = records::OtherSizeIn(file, reader->size()))
      mistakes.Add(
          file, "",
          fmt::format("its images change from {} x {} to {} x {} pixels, and a calibration is of one size",
                      reader->size().width, reader->size().height, other->width, other->height),
          "valid: the parts by themselves; ffmpeg -ss and -to cut them out");
    input.next = [reader, number = 0, rate = input.rate_hz]() mutable -> std::optional<vision::Frame> {
      auto image = reader->Next();
      if (!image) return std::nullopt;
      const int i = number++;
      return vision::Frame{std::move(*image), i / rate, i};
    };
  } catch (const std::runtime_error& e) {
    mistakes.Add(file, "", fmt::format("neither an image nor a video: {}", e.what()));
  }
  return input;
}

Input LiveInput(const std::string& address, Mistakes& mistakes) {
  Input input;
  try {
    const vision::CameraAddress parsed = vision::ParseCameraAddress(address);
    const cv::Size size = vision::SizeAt(parsed);
    if (!size.empty()) input.size = size;
    const auto camera =
        std::make_shared<vision::LiveCamera>(vision::SourceAt(parsed), vision::LiveCameraOptions{});
    input.next = [camera]() -> std::optional<vision::Frame> {
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

Input Open(const TrackArguments& a, Mistakes& mistakes) {
  std::error_code none;
  if (!fs::exists(a.input, none) && a.input.find(':') != std::string::npos)
    return LiveInput(a.input, mistakes);
  return !IsFile(a.input) || vision::LooksLikeImage(a.input) ? StillInput(a, mistakes)
                                                             : VideoInput(a.input, mistakes);
}

// A pad by its name or file, or any picture with a size.
vision::PadReference ReadLandmark(const TrackArguments& a, Mistakes& mistakes) {
  const bool is_picture = vision::LooksLikeImage(a.landmark);
  if (!is_picture) {
    if (!a.size_m.empty())
      mistakes.Add("--size-m", "", fmt::format("'{}' is no picture: a pad's file has its size", a.landmark),
                   "valid: without it, or an image file");
    std::string name = a.landmark;
    const auto file = ModelFile(Model::kPad, name, "", "--landmark", mistakes);
    return file ? vision::LoadPad(*file, mistakes).reference : vision::PadReference{};
  }
  std::string note;
  const cv::Mat grey = vision::ReadImage(a.landmark, vision::ImageColours::kGrey, a.bits, mistakes, note);
  if (a.size_m.empty())
    mistakes.Add("--size-m", "", "not given: a picture does not tell how large it is",
                 "valid: its height and width in metres, or its height alone");
  if (grey.empty() || a.size_m.empty()) return {};
  const double height = a.size_m[0],
               width = a.size_m.size() > 1 ? a.size_m[1] : height * grey.cols / grey.rows;
  return vision::ReferenceOfPicture(grey, {height, width}, a.landmark, "--landmark", "", mistakes);
}

void CheckOutputs(const TrackArguments& a, bool still, Mistakes& mistakes) {
  if (!a.out.empty() && !(still ? HasEnding(a.out, {".png", ".jpg", ".jpeg"}) : HasEnding(a.out, {".mp4"})))
    mistakes.Add(
        "--out", "",
        fmt::format("'{}' does not name {}", a.out,
                    still ? "an image; valid: an ending .png or .jpg" : "a video; valid: an ending .mp4"));
  for (const auto& [option, file] : {std::pair{"--out", a.out}, {"--csv", a.csv}}) {
    CheckWritableFile(file, option, mistakes);
    for (const std::string& taken : {a.input, a.camera, a.landmark})
      if (!file.empty() && !taken.empty() && SameFile(file, taken))
        mistakes.Add(option, "", fmt::format("'{}' is read", file), "valid: another file");
  }
  if (!a.out.empty() && a.out == a.csv)
    mistakes.Add("--csv", "", fmt::format("'{}' is that of --out too", a.csv), "valid: another file");
}

struct Times {
  double read_s = 0, track_s = 0, draw_s = 0;
};

// Follows through all images. Every frame is told, drawn and written as asked.
template <class Tracked>
void Follow(const TrackArguments& a, Input& input, Tracked& tracked, const cv::Size& size) {
  std::string csv = "frame,t_s," + Tracked::Columns() + ",read_ms,track_ms\n";
  std::optional<records::Video> out;
  if (!a.out.empty() && !input.still) out.emplace(a.out, input.rate_hz);
  Times sum;
  int frames = 0, with = 0;
  std::string broke_off;
  const bool shows_progress = !a.quiet && isatty(STDERR_FILENO);
  while (!stopped && (a.frames == 0 || frames < a.frames)) {
    Times now;
    auto start = std::chrono::steady_clock::now();
    std::optional<vision::Frame> frame;
    try {
      frame = input.next();
    } catch (const std::runtime_error& e) {
      broke_off = e.what();
    }
    now.read_s = SecondsSince(start);
    if (!frame) break;
    if (frame->image.size() != size) {
      broke_off = fmt::format(
          "an image of {} x {} pixels, and the camera's file is of {} x {}; give the camera's "
          "address its size, or calibrate at this one",
          frame->image.cols, frame->image.rows, size.width, size.height);
      break;
    }
    start = std::chrono::steady_clock::now();
    const bool seen = tracked.Track(frame->image);
    now.track_s = SecondsSince(start);
    with += seen;
    csv += fmt::format("{},{:.4f},{},{:.2f},{:.2f}\n", frame->sequence, frame->t_s, tracked.Row(),
                       1e3 * now.read_s, 1e3 * now.track_s);
    if (!a.out.empty()) {
      start = std::chrono::steady_clock::now();
      cv::Mat drawn = frame->image.clone();
      if (drawn.channels() == 1) cv::cvtColor(drawn, drawn, cv::COLOR_GRAY2BGR);
      tracked.Draw(drawn);
      now.draw_s = SecondsSince(start);
      if (out)
        out->Write(drawn);
      else
        vision::WriteImage(a.out, drawn);
    }
    sum.read_s += now.read_s, sum.track_s += now.track_s, sum.draw_s += now.draw_s;
    if (input.still && !a.quiet) fmt::print("{}\n", tracked.Sentence());
    ++frames;
    if (shows_progress && frames % 10 == 0) fmt::print(stderr, "\r\033[Kframe {}", frames);
  }
  if (shows_progress) fmt::print(stderr, "\r\033[K");
  if (out) out->Close();
  if (!a.csv.empty()) WriteFile(a.csv, csv);
  if (!a.quiet && !input.still) fmt::print("{} frames, seen in {}\n", frames, with);
  if (!a.quiet && frames > 0)
    fmt::print("per frame: reading {:.1f} ms, tracking {:.1f} ms, drawing {:.1f} ms\n",
               1e3 * sum.read_s / frames, 1e3 * sum.track_s / frames, 1e3 * sum.draw_s / frames);
  if (!broke_off.empty())
    throw std::runtime_error(
        fmt::format("{}: it broke off after {} frames, which are written: {}", a.input, frames, broke_off));
}

}  // namespace

CLI::App* AddTrackCommand(CLI::App& app, TrackArguments& a) {
  CLI::App* command = app.add_subcommand(
      "track", "Find and follow a landmark or a ball, and measure where it is from the camera");
  command->add_option("input", a.input, "An image, a video file or a camera's address, as of kestrel fly")
      ->type_name("INPUT")
      ->required();
  command
      ->add_option("--camera", a.camera,
                   "A name in models/cameras, or a calibration file of Kestrel, Kalibr or OpenCV")
      ->type_name("CAMERA")
      ->required();
  command->add_option("--camera-name", a.camera_name, "Which camera of a Kalibr file (default: its first)");
  command
      ->add_option("--landmark", a.landmark,
                   "A name in models/pads, the file of a pad, or any picture that lies or hangs flat")
      ->type_name("PAD");
  command->add_option("--size-m", a.size_m, "Height and width of a picture in metres, or its height alone")
      ->type_name("METRES")
      ->expected(1, 2)
      ->check(CLI::Range(0.01, 100.0));
  command
      ->add_option(
          "--corners", a.corners,
          "Where the landmark is in the first image: the pixels of its picture's top left, top right, bottom "
          "right and bottom left corner. Without them it is searched")
      ->type_name("X,Y")
      ->expected(4);
  command
      ->add_option(
          "--ball", a.ball,
          "A ball instead of a landmark: hue=DEGREES diameter_m=METRES, and if need be hue_half_width_deg, "
          "min_saturation, min_value, max_value")
      ->type_name("KEY=VALUE")
      ->expected(1, 6);
  command->add_option("--out", a.out, "Picture (.png, .jpg) or video (.mp4) with what was seen drawn on it")
      ->type_name("FILE");
  command->add_option("--csv", a.csv, "A row for each frame: pose, covariance, quality, times")
      ->type_name("FILE");
  command
      ->add_option("--frames", a.frames,
                   "End after so many frames (default: with the input, or when interrupted)")
      ->check(CLI::Range(1, 100000000));
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  kestrel track flight.mp4 --landmark helipad --camera thesis_6mm --out seen.mp4 --csv pose.csv\n"
      "  kestrel track photo.jpg --landmark poster.jpg --size-m 0.42 0.297 --camera my_calibration.yaml\n"
      "  kestrel track v4l2:/dev/video0 --ball hue=0 diameter_m=0.5 --camera my_calibration.yaml --csv "
      "ball.csv");
  return command;
}

void TrackCommand(const TrackArguments& a) {
  Mistakes mistakes;
  Input input = Open(a, mistakes);
  vision::CameraModel camera;
  bool has_camera = false;
  std::string name = a.camera;
  if (const auto file = ModelFile(Model::kCamera, name, "", "--camera", mistakes)) {
    const std::size_t before = mistakes.all().size();
    camera = vision::LoadCamera(*file, mistakes, a.camera_name, input.size);
    has_camera = mistakes.all().size() == before;
  }
  if (a.landmark.empty() == a.ball.empty())
    mistakes.Add("--landmark", "",
                 a.ball.empty() ? "not given, and no --ball" : "a landmark, and a --ball too",
                 "valid: one of them");
  CheckOutputs(a, input.still, mistakes);
  stopped = false;
  const auto note = [&] {
    if (!a.quiet && !input.note.empty()) fmt::print("{}\n", input.note);
    if (!input.still) OnEndSignals([](int) { stopped = true; });
  };
  const cv::Size size = has_camera ? cv::Size(vision::WidthPx(camera), vision::HeightPx(camera)) : cv::Size();
  if (!a.ball.empty()) {
    if (!a.corners.empty() || !a.size_m.empty())
      mistakes.Add("--ball", "", "with --corners or --size-m, which are of a landmark",
                   "valid: without them");
    const BallParameters ball = ReadBall(a.ball, mistakes);
    mistakes.ThrowIfAny();
    note();
    TrackedBall tracked(ball, camera);
    return Follow(a, input, tracked, size);
  }
  vision::PadReference reference;
  if (!a.landmark.empty()) reference = ReadLandmark(a, mistakes);
  const auto corners = ReadCorners(a.corners, input.size, mistakes);
  if (has_camera && !mission::TrackersCamera(camera))
    mistakes.Add("--camera", "", "does not see along its own axis", "valid: a camera that does");
  mistakes.ThrowIfAny();
  TrackedLandmark tracked(std::move(reference), camera, corners, mistakes);
  mistakes.ThrowIfAny();
  note();
  Follow(a, input, tracked, size);
}

}  // namespace kestrel::app
