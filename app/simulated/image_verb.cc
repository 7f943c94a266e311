// SPDX-License-Identifier: Apache-2.0
#include "app/simulated/image_verb.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>

#include "app/option/within.h"
#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/user_file.h"
#include "records/video/video_reader.h"
#include "vision/camera/calibration_file.h"
#include "vision/camera/camera_mount.h"
#include "vision/image_file.h"
#include "vision/write_image.h"

namespace kestrel::app {

Pose PoseOf(const MountAngles& mount) {
  return vision::MountPose({.position_m = Eigen::Vector3d::Zero(),
                            .yaw_deg = mount.yaw_deg,
                            .pitch_deg = mount.pitch_deg,
                            .roll_deg = mount.roll_deg});
}

void AddCameraOptions(CLI::App& command, ImageArguments& a) {
  CLI::Option* camera =
      command
          .add_option("--camera", a.camera,
                      "A name in models/cameras, or a calibration file of Kestrel, Kalibr, OpenCV or EuRoC "
                      "(default: what a recording has of its camera)")
          ->type_name("CAMERA");
  command.add_option("--camera-name", a.camera_name, "Which camera of a Kalibr file (default: its first)")
      ->needs(camera);
}

void AddMountOptions(CLI::App& command, MountAngles& mount) {
  command
      .add_option("--mount-yaw-deg", mount.yaw_deg,
                  "How the camera is mounted: looking down with the top of the image forward, then turned")
      ->check(Within(-180.0, 180.0))
      ->capture_default_str();
  command.add_option("--mount-pitch-deg", mount.pitch_deg, "0: looking down; 90: looking ahead")
      ->check(Within(-90.0, 90.0))
      ->capture_default_str();
  command.add_option("--mount-roll-deg", mount.roll_deg, "180: looking up")
      ->check(Within(-180.0, 180.0))
      ->capture_default_str();
}

void AddFramesOption(CLI::App& command, const std::string& images, int& frames) {
  command
      .add_option("--frames", frames,
                  fmt::format("End after so many {} (default: with the input, or when interrupted)", images))
      ->check(WholeNumber(1, 100000000));
}

void AddOutputOptions(CLI::App& command, const std::string& csv_rows, ImageArguments& a) {
  command.add_option("--out", a.out, "Picture (.png, .jpg) or video (.mp4) with what was seen drawn on it")
      ->type_name("FILE");
  command.add_option("--csv", a.csv, csv_rows)->type_name("FILE");
}

ImageInput OpenImageFile(const ImageArguments& a, Mistakes& mistakes) {
  ImageInput input;
  if (!IsFile(a.input) || vision::LooksLikeImage(a.input)) {
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
  try {
    const auto reader = std::make_shared<records::VideoReader>(a.input);
    input.size = reader->size();
    input.rate_hz = reader->rate_hz();
    input.next = [reader, number = 0, rate = input.rate_hz]() mutable -> std::optional<vision::Frame> {
      auto image = reader->Next();
      if (!image) return std::nullopt;
      const int i = number++;
      return vision::Frame{std::move(*image), i / rate, i};
    };
  } catch (const std::runtime_error& e) {
    mistakes.Add(a.input, "", fmt::format("neither an image nor a video: {}", e.what()));
  }
  return input;
}

std::optional<std::filesystem::path> CameraFile(const ImageArguments& a, const ImageInput& input,
                                                Mistakes& mistakes) {
  if (a.camera.empty() && !input.calibration.empty()) return input.calibration;
  if (a.camera.empty()) {
    if (input.next)  // otherwise it is told already why there is no input
      mistakes.Add("--camera", "", "not given, and the input has no calibration of its own",
                   "valid: a name in models/cameras, or a calibration file");
    return std::nullopt;
  }
  std::string name = a.camera;
  return ModelFile(Model::kCamera, name, "", "--camera", mistakes);
}

std::optional<vision::CameraModel> ReadCamera(const ImageArguments& a, const ImageInput& input,
                                              Mistakes& mistakes) {
  const std::size_t before = mistakes.all().size();
  vision::CameraModel camera;
  if (a.camera.empty() && !input.calibration_text.empty()) {
    const Config config = ParseConfig(input.calibration_text, a.input + ": camera_info", {}, mistakes);
    camera = vision::ParseCamera(config, mistakes, a.camera_name, input.size);
  } else if (const auto file = CameraFile(a, input, mistakes)) {
    camera = vision::LoadCamera(*file, mistakes, a.camera_name, input.size);
  }
  if (mistakes.all().size() > before) return std::nullopt;
  return camera;
}

void CheckOutputFiles(const ImageArguments& a, bool still, const std::string& also_read, Mistakes& mistakes) {
  if (!a.out.empty() && !(still ? HasEnding(a.out, {".png", ".jpg", ".jpeg"}) : HasEnding(a.out, {".mp4"})))
    mistakes.Add(
        "--out", "",
        fmt::format("'{}' does not name {}", a.out,
                    still ? "an image; valid: an ending .png or .jpg" : "a video; valid: an ending .mp4"));
  for (const auto& [option, file] : {std::pair{"--out", a.out}, {"--csv", a.csv}}) {
    CheckWritableFile(file, option, mistakes);
    for (const std::string& taken : {a.input, a.camera, also_read})
      if (!file.empty() && !taken.empty() && SameFile(file, taken))
        mistakes.Add(option, "", fmt::format("'{}' is read", file), "valid: another file");
  }
  if (!a.out.empty() && a.out == a.csv)
    mistakes.Add("--csv", "", fmt::format("'{}' is that of --out too", a.csv), "valid: another file");
}

DrawnFile::DrawnFile(const ImageArguments& a, const ImageInput& input) : file_(a.out) {
  if (wanted() && !input.still) video_.emplace(file_, input.rate_hz);
}

void DrawnFile::Write(const cv::Mat& bgr) {
  if (video_)
    video_->Write(bgr);
  else
    vision::WriteImage(file_, bgr);
}

void DrawnFile::Close() {
  if (video_) video_->Close();
}

FrameProgress::FrameProgress(bool wanted) : wanted_(wanted && isatty(STDERR_FILENO)) {}

void FrameProgress::Show(int frames) {
  if (!wanted_ || frames % 10 != 0) return;
  fmt::print(stderr, "\r\033[Kframe {}", frames);
  shown_ = true;
}

void FrameProgress::Clear() {
  if (std::exchange(shown_, false)) fmt::print(stderr, "\r\033[K");
}

}  // namespace kestrel::app
