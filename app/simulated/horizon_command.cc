// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/horizon_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "app/option/bits_option.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/user_file.h"
#include "flight/simulated/scenario.h"
#include "geometry/tait_bryan.h"
#include "records/video/video.h"
#include "records/video/video_reader.h"
#include "vision/camera/calibration_file.h"
#include "vision/horizon/horizon_attitude.h"
#include "vision/image_file.h"
#include "vision/write_image.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCsvHeader =
    "frame,t_s,roll_deg,pitch_deg,roll_sigma_deg,pitch_sigma_deg,dip_deg,skyline_seen,turned_deg,"
    "turned_sigma_deg,reason\n";

std::string Row(int frame, double t_s, const vision::HorizonAttitude::Measurement& m) {
  std::string row = fmt::format("{},{:.4f},", frame, t_s);
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
    fmt::print("no attitude: {}\n", vision::NameOf(std::get<vision::NoSkyline>(m.skyline)));
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

// How a camera is mounted is not seen in its images, and without a word it is taken to look down.
void TellOfMount(const HorizonArguments& a) {
  if (a.pitch_deg == 0 && a.roll_deg == 0)
    fmt::print("the camera was taken to look down; for one that looks ahead give --mount-pitch-deg 90\n");
}

}  // namespace

CLI::App* AddHorizonCommand(CLI::App& app, HorizonArguments& a) {
  CLI::App* command = app.add_subcommand(
      "horizon", "Find roll and pitch by the skyline, and the heading by the surroundings");
  command->add_option("input", a.input, "An image or a video file in colour, as the camera took it")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--camera", a.camera,
                   "A name in models/cameras, or a calibration file of Kestrel, Kalibr or OpenCV")
      ->type_name("CAMERA")
      ->required();
  command->add_option("--camera-name", a.camera_name, "Which camera of a Kalibr file (default: its first)");
  command
      ->add_option("--mount-yaw-deg", a.yaw_deg,
                   "How the camera is mounted: looking down with the top of the image forward, then turned")
      ->check(CLI::Range(-180.0, 180.0))
      ->capture_default_str();
  command->add_option("--mount-pitch-deg", a.pitch_deg, "0: looking down; 90: looking ahead")
      ->check(CLI::Range(-90.0, 90.0))
      ->capture_default_str();
  command->add_option("--mount-roll-deg", a.roll_deg, "180: looking up")
      ->check(CLI::Range(-180.0, 180.0))
      ->capture_default_str();
  command
      ->add_option("--mask", a.mask, "An image of the same size, not black where the aircraft itself is seen")
      ->type_name("FILE");
  command->add_option("--out", a.out, "Picture (.png, .jpg) or video (.mp4) with what was seen drawn on it")
      ->type_name("FILE");
  command->add_option("--csv", a.csv, "A row for each frame")->type_name("FILE");
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  kestrel horizon flight.mp4 --camera hyperbolic_mirror --out seen.mp4 --csv attitude.csv\n"
      "  kestrel horizon photo.jpg --camera my_calibration.yaml --mount-pitch-deg 90 --out seen.png");
  return command;
}

void HorizonCommand(const HorizonArguments& a) {
  Mistakes mistakes;
  cv::Mat image, mask;
  std::optional<records::VideoReader> video;
  std::optional<cv::Size> size;
  std::string note;
  if (!IsFile(a.input) || vision::LooksLikeImage(a.input)) {
    image = vision::ReadImage(a.input, vision::ImageColours::kColour, a.bits, mistakes, note);
    if (!image.empty()) size = image.size();
  } else {
    try {
      size = video.emplace(a.input).size();
    } catch (const std::runtime_error& e) {
      mistakes.Add(a.input, "", fmt::format("neither an image nor a video: {}", e.what()));
    }
  }
  vision::CameraModel camera;
  std::string name = a.camera;
  if (const auto file = ModelFile(Model::kCamera, name, "", "--camera", mistakes))
    camera = vision::LoadCamera(*file, mistakes, a.camera_name, size);
  if (!a.mask.empty()) {
    mask = vision::ReadMask(a.mask, "--mask", "", mistakes);
    if (!mask.empty() && size && mask.size() != *size)
      mistakes.Add("--mask", "", fmt::format("{} x {} pixels", mask.cols, mask.rows),
                   fmt::format("valid: those of the input, {} x {}", size->width, size->height));
  }
  if (!a.out.empty() && !(video ? HasEnding(a.out, {".mp4"}) : HasEnding(a.out, {".png", ".jpg", ".jpeg"})))
    mistakes.Add(
        "--out", "",
        fmt::format("'{}' does not name {}", a.out,
                    video ? "a video; valid: an ending .mp4" : "an image; valid: an ending .png or .jpg"));
  for (const auto& [option, file] : {std::pair{"--out", a.out}, {"--csv", a.csv}}) {
    CheckWritableFile(file, option, mistakes);
    for (const std::string& taken : {a.input, a.camera, a.mask})
      if (!file.empty() && !taken.empty() && SameFile(file, taken))
        mistakes.Add(option, "", fmt::format("'{}' is read", file), "valid: another file");
  }
  if (!a.out.empty() && a.out == a.csv)
    mistakes.Add("--csv", "", fmt::format("'{}' is that of --out too", a.csv), "valid: another file");
  mistakes.ThrowIfAny();

  const Pose X_BC =
      vision::MountPose({.yaw_deg = a.yaw_deg, .pitch_deg = a.pitch_deg, .roll_deg = a.roll_deg});
  vision::HorizonAttitude horizon(camera, X_BC.R.toRotationMatrix(), mask, {}, {});
  std::string csv = kCsvHeader;
  if (!video) {
    const auto m = horizon.Measure(image);
    if (!a.quiet && !note.empty()) fmt::print("{}\n", note);
    if (!a.quiet) Tell(m);
    if (!a.quiet && !m.attitude) TellOfMount(a);
    csv += Row(0, 0, m);
    if (!a.out.empty()) vision::WriteImage(a.out, horizon.Draw(image, m));
  } else {
    std::optional<records::Video> out;
    if (!a.out.empty()) out.emplace(a.out, video->rate_hz());
    int frames = 0, with = 0;
    for (; const auto frame = video->Next(); ++frames) {
      const auto m = horizon.Measure(*frame);
      with += m.attitude.has_value();
      csv += Row(frames, frames / video->rate_hz(), m);
      if (out) out->Write(horizon.Draw(*frame, m));
      if (!a.quiet && isatty(STDERR_FILENO) && frames % 10 == 0)
        fmt::print(stderr, "\r\033[Kframe {}", frames);
    }
    if (!a.quiet && isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[K");
    if (out) out->Close();
    if (!a.quiet) fmt::print("{} frames, {} with an attitude\n", frames, with);
    if (!a.quiet && 2 * with < frames) TellOfMount(a);
  }
  if (!a.csv.empty()) WriteFile(a.csv, csv);
}

}  // namespace kestrel::app
