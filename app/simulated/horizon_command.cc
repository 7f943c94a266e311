// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/horizon_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <variant>

#include "app/option/bits_option.h"
#include "app/simulated/image_verb.h"
#include "app/simulated/images_input.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/end_signals.h"
#include "geometry/tait_bryan.h"
#include "mission/caption/strip.h"
#include "vision/horizon/border/straight_skyline.h"
#include "vision/horizon/horizon_attitude.h"
#include "vision/image_file.h"

namespace kestrel::app {
namespace {

std::atomic<bool> horizon_ends = false;

constexpr const char* kCsvHeader =
    "frame,t_s,roll_deg,pitch_deg,roll_sigma_deg,pitch_sigma_deg,dip_deg,skyline_seen,turned_deg,"
    "turned_sigma_deg,reason\n";

std::string Row(std::int64_t frame, double t_s, const vision::HorizonAttitude::Measurement& m) {
  std::string row = fmt::format("{},{:.9f},", frame, t_s);
  const auto* fix = std::get_if<vision::SkylineFix>(&m.skyline);
  if (!fix) return row + fmt::format(",,,,,,,,{}\n", vision::NameOf(std::get<vision::NoSkyline>(m.skyline)));
  row += fmt::format("{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},", Degrees(m.attitude->roll),
                     Degrees(m.attitude->pitch), Degrees(std::sqrt(m.attitude->covariance(0, 0))),
                     Degrees(std::sqrt(m.attitude->covariance(1, 1))), Degrees(fix->dip), fix->circle_seen);
  if (const auto* heading = std::get_if<vision::CompassHeading>(&m.compass))
    return row +
           fmt::format("{:.3f},{:.3f},\n", Degrees(heading->turned), Degrees(std::sqrt(heading->variance)));
  return row + fmt::format(",,{}\n", vision::NameOf(std::get<vision::NoHeading>(m.compass)));
}

void Tell(const vision::HorizonAttitude::Measurement& m) {
  if (!m.attitude) {
    const auto reason = std::get<vision::NoSkyline>(m.skyline);
    fmt::print("no attitude: {}: {}\n", vision::NameOf(reason), vision::MeaningOf(reason));
    return;
  }
  const vision::SkylineFix& fix = std::get<vision::SkylineFix>(m.skyline);
  fmt::print(
      "roll {:.2f} +- {:.2f} deg, pitch {:.2f} +- {:.2f} deg (one standard deviation); skyline in {:.0f} % "
      "of all "
      "directions, dip {:.2f} deg\n",
      Degrees(m.attitude->roll), Degrees(std::sqrt(m.attitude->covariance(0, 0))), Degrees(m.attitude->pitch),
      Degrees(std::sqrt(m.attitude->covariance(1, 1))), 100 * fix.circle_seen, Degrees(fix.dip));
}

bool MountGiven(const HorizonArguments& a) {
  return a.mount_given || a.mount.pitch_deg != 0 || a.mount.roll_deg != 0;
}

// A lens that looks one way sees no horizon if it looks down: without a word it is taken to look ahead, and any
// other to look down.
MountAngles MountOf(const HorizonArguments& a, const vision::CameraModel& camera) {
  MountAngles mount = a.mount;
  if (!MountGiven(a) && vision::StraightSkyline::Suits(camera)) mount.pitch_deg = 90;
  return mount;
}

void TellOfMount(const MountAngles& mount) {
  if (mount.pitch_deg == 0 && mount.roll_deg == 0)
    fmt::print("the camera was taken to look down; for one that looks ahead give --mount-pitch-deg 90\n");
}

}  // namespace

CLI::App* AddHorizonCommand(CLI::App& app, HorizonArguments& a) {
  CLI::App* command = app.add_subcommand(
      "horizon", "Find roll and pitch by the skyline, and the heading by the surroundings");
  command
      ->add_option(
          "input", a.input,
          "In colour, as the camera took it: an image, a video file, a folder of images, a recording "
          "(EuRoC, TUM, KITTI, MCAP) or a camera's address, as of kestrel fly")
      ->type_name("INPUT")
      ->required();
  AddCameraOptions(*command, a);
  AddRecordingOptions(*command, a);
  AddMountOptions(*command, a.mount);
  command->parse_complete_callback([command, &a] {
    a.mount_given = command->count("--mount-pitch-deg") + command->count("--mount-roll-deg") > 0;
  });
  command
      ->add_option("--mask", a.mask, "An image of the same size, not black where the aircraft itself is seen")
      ->type_name("FILE");
  AddOutputOptions(*command, "A row for each frame", a);
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  kestrel horizon flight.mp4 --camera hyperbolic_mirror --out seen.mp4 --csv attitude.csv\n"
      "  kestrel horizon EUROC --topic cam1 --mount-pitch-deg 90 --csv attitude.csv\n"
      "  kestrel horizon photo.jpg --camera my_calibration.yaml --out seen.png");
  return command;
}

void HorizonCommand(const HorizonArguments& a) {
  Mistakes mistakes;
  horizon_ends = false;
  ImageInput input = OpenImages(a, horizon_ends, mistakes);
  const vision::CameraModel camera = ReadCamera(a, input, mistakes).value_or(vision::CameraModel());
  cv::Mat mask;
  if (!a.mask.empty()) {
    mask = vision::ReadMask(a.mask, "--mask", "", mistakes);
    if (!mask.empty() && input.size && mask.size() != *input.size)
      mistakes.Add("--mask", "", fmt::format("{} x {} pixels", mask.cols, mask.rows),
                   fmt::format("valid: those of the input, {} x {}", input.size->width, input.size->height));
  }
  CheckOutputFiles(a, input.still, a.mask, mistakes);
  mistakes.ThrowIfAny();

  const MountAngles mount = MountOf(a, camera);
  if (!a.quiet && mount.pitch_deg != a.mount.pitch_deg)
    fmt::print("the camera is taken to look ahead; for one that looks elsewhere give --mount-pitch-deg\n");
  vision::HorizonAttitude horizon(camera, PoseOf(mount).R.toRotationMatrix(), mask, {}, {});
  std::string csv = kCsvHeader;
  DrawnFile out(a, input);
  FrameProgress progress(!a.quiet);
  int frames = 0, with = 0;
  if (!a.quiet && !input.note.empty()) fmt::print("{}\n", input.note);
  if (!input.still) OnEndSignals([](int) { horizon_ends = true; });
  const cv::Size size(vision::WidthPx(camera), vision::HeightPx(camera));
  std::string broke_off;
  while (!horizon_ends) {
    std::optional<vision::Frame> frame;
    try {
      frame = NextImage(input, frames, a.quiet);
    } catch (const std::runtime_error& e) {
      broke_off = e.what();
    }
    if (!frame) break;
    progress.Show(++frames);
    if (frame->image.empty()) {
      csv += fmt::format("{},{:.9f},,,,,,,,,unreadable\n", frame->sequence, frame->t_s);
      continue;
    }
    if (frame->image.size() != size) {
      broke_off = fmt::format("an image of {} x {} pixels, and the camera's file is of {} x {}",
                              frame->image.cols, frame->image.rows, size.width, size.height);
      break;
    }
    if (frame->image.channels() == 1) cv::cvtColor(frame->image, frame->image, cv::COLOR_GRAY2BGR);
    const auto m = horizon.Measure(frame->image);
    with += m.attitude.has_value();
    csv += Row(frame->sequence, frame->t_s, m);
    if (input.still && !a.quiet) Tell(m);
    if (out.wanted()) {
      mission::StripText text;
      for (const std::string& words : horizon.Words(m)) text.captions.push_back({words});
      out.Write(mission::WithStrip(horizon.Draw(frame->image, m), text, 2));
    }
  }
  progress.Clear();
  out.Close();
  if (!a.quiet && !input.still) fmt::print("{} frames, {} with an attitude\n", frames, with);
  if (!a.quiet && 2 * with < frames) TellOfMount(mount);
  if (!a.csv.empty()) WriteFile(a.csv, csv);
  if (!broke_off.empty())
    throw std::runtime_error(
        fmt::format("{}: it broke off after {} frames, which are written: {}", a.input, frames, broke_off));
}

}  // namespace kestrel::app
