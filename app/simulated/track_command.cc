// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/track_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "app/option/bits_option.h"
#include "app/option/within.h"
#include "app/simulated/image_verb.h"
#include "app/simulated/images_input.h"
#include "app/simulated/tracked.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/process/end_signals.h"
#include "base/stopwatch.h"
#include "mission/caption/strip.h"
#include "mission/helipad_pilot.h"
#include "vision/image_file.h"
#include "vision/landmark/pad_file.h"

namespace kestrel::app {
namespace {

std::atomic<bool> stopped = false;

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

struct Times {
  double read_s = 0, track_s = 0, draw_s = 0;
};

// Follows through all images. Every frame is told, drawn and written as asked.
template <class Tracked>
void Follow(const TrackArguments& a, ImageInput& input, Tracked& tracked, const cv::Size& size) {
  std::string csv = "frame,t_s," + Tracked::Columns() + ",read_ms,track_ms\n";
  DrawnFile out(a, input);
  FrameProgress progress(!a.quiet);
  Times sum;
  int frames = 0, with = 0;
  std::string broke_off;
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
    if (Tracked::kByColour && frame->image.channels() == 1) {
      broke_off =
          "its images are grey, and a ball is known by its colour; colour=true in a camera's address asks "
          "for it";
      break;
    }
    start = std::chrono::steady_clock::now();
    const bool seen = tracked.Track(frame->image);
    now.track_s = SecondsSince(start);
    with += seen;
    csv += fmt::format("{},{:.9f},{},{:.2f},{:.2f}\n", frame->sequence, frame->t_s, tracked.Row(),
                       1e3 * now.read_s, 1e3 * now.track_s);
    if (out.wanted()) {
      start = std::chrono::steady_clock::now();
      cv::Mat drawn = frame->image.clone();
      if (drawn.channels() == 1) cv::cvtColor(drawn, drawn, cv::COLOR_GRAY2BGR);
      tracked.Draw(drawn);
      try {
        out.Write(mission::WithStrip(drawn, {{}, {}, tracked.Captions()}, 1));
      } catch (const std::runtime_error& e) {
        broke_off = e.what();
        break;
      }
      now.draw_s = SecondsSince(start);
    }
    sum.read_s += now.read_s, sum.track_s += now.track_s, sum.draw_s += now.draw_s;
    if (input.still && !a.quiet) fmt::print("{}\n", tracked.Sentence());
    progress.Show(++frames);
  }
  progress.Clear();
  if (!a.csv.empty()) WriteFile(a.csv, csv);
  try {
    out.Close();
  } catch (const std::runtime_error& e) {
    if (broke_off.empty()) broke_off = e.what();
  }
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
  command
      ->add_option(
          "input", a.input,
          "An image, a video file, a folder of images, a recording (EuRoC, TUM, KITTI, MCAP) or a camera's "
          "address, as of kestrel fly")
      ->type_name("INPUT")
      ->required();
  AddCameraOptions(*command, a);
  AddRecordingOptions(*command, a);
  command
      ->add_option("--landmark", a.landmark,
                   "A name in models/pads, the file of a pad, or any picture that lies or hangs flat")
      ->type_name("PAD");
  command->add_option("--size-m", a.size_m, "Height and width of a picture in metres, or its height alone")
      ->type_name("METRES")
      ->expected(1, 2)
      ->check(Within(0.01, 100.0));
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
  AddOutputOptions(*command, "A row for each frame: pose, covariance, quality, times", a);
  AddFramesOption(*command, "frames", a.frames);
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  kestrel track flight.mp4 --landmark helipad --camera thesis_6mm --out seen.mp4 --csv pose.csv\n"
      "  kestrel track EUROC --topic cam1 --landmark helipad --csv pose.csv\n"
      "  kestrel track photo.jpg --landmark poster.jpg --size-m 0.42 0.297 --camera my_calibration.yaml\n"
      "  kestrel track v4l2:/dev/video0,colour=true --ball hue=0 diameter_m=0.5 --camera my_calibration.yaml "
      "--csv "
      "ball.csv");
  return command;
}

void TrackCommand(const TrackArguments& a) {
  Mistakes mistakes;
  ImageInput input = OpenImages(a, stopped, mistakes);
  const std::optional<vision::CameraModel> loaded = ReadCamera(a, input, mistakes);
  const vision::CameraModel camera = loaded.value_or(vision::CameraModel());
  if (a.landmark.empty() == a.ball.empty())
    mistakes.Add("--landmark", "",
                 a.ball.empty() ? "not given, and no --ball" : "a landmark, and a --ball too",
                 "valid: one of them");
  CheckOutputFiles(a, input.still, a.landmark, mistakes);
  stopped = false;
  const auto note = [&] {
    if (!a.quiet && !input.note.empty()) fmt::print("{}\n", input.note);
    if (!input.still) OnEndSignals([](int) { stopped = true; });
  };
  const cv::Size size = loaded ? cv::Size(vision::WidthPx(camera), vision::HeightPx(camera)) : cv::Size();
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
  if (loaded && !mission::TrackersCamera(camera))
    mistakes.Add("--camera", "", "does not see along its own axis", "valid: a camera that does");
  mistakes.ThrowIfAny();
  TrackedLandmark tracked(std::move(reference), camera, corners, mistakes);
  mistakes.ThrowIfAny();
  note();
  Follow(a, input, tracked, size);
}

}  // namespace kestrel::app
