// SPDX-License-Identifier: Apache-2.0
#include "app/stabilise/stabilise_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <initializer_list>
#include <string>

#include "app/option/bits_option.h"
#include "app/option/one_of.h"
#include "app/option/opencl_option.h"
#include "app/option/within.h"
#include "app/simulated/images_input.h"
#include "app/stabilise/gyro_input.h"
#include "app/stabilise/stabilise_video.h"
#include "base/diagnostics.h"
#include "base/process/end_signals.h"

namespace kestrel::app {
namespace {

std::atomic<bool> stopped = false;

bool ByGyro(const StabiliseArguments& a) { return a.options.by == "gyro" || a.options.by == "both"; }

// Options that others make meaningless would be left out without a word.
void RefuseUseless(const CLI::App& command, const StabiliseArguments& a) {
  const auto refuse = [&](bool useless, const std::string& where, std::initializer_list<const char*> names) {
    for (const char* name : names)
      if (useless && command.count(name) > 0)
        throw CLI::ValidationError(fmt::format("{} is of no use to {}", name, where));
  };
  refuse(a.options.mode == "reference", "--mode reference", {"--lag-s", "--cutoff-hz", "--unbounded"});
  refuse(a.options.mode == "offline", "--mode offline", {"--lag-s"});
  refuse(a.options.by == "sphere", "--by sphere", {"--model"});
  refuse(a.options.by == "gyro", "--by gyro", {"--model", "--method", "--points", "--opencl"});
  refuse(a.level == "none", "--level none", {"--mount-yaw-deg", "--mount-pitch-deg", "--mount-roll-deg"});
}

}  // namespace

CLI::App* AddStabiliseCommand(CLI::App& app, StabiliseArguments& a) {
  CLI::App* command =
      app.add_subcommand("stabilise", "Steady a video: the view stands still, or goes along a smooth path");
  command
      ->add_option("input", a.input,
                   "A video file, a folder of images, a recording (EuRoC, TUM, KITTI, MCAP) or a camera's "
                   "address, as of "
                   "kestrel fly")
      ->type_name("INPUT")
      ->required();
  command
      ->add_option(
          "--mode", a.options.mode,
          "reference: the view stands still; smooth: it goes smoothly, late by --lag-s; offline: the same, "
          "with all the images that count")
      ->check(OneOf({"reference", "smooth", "offline"}))
      ->capture_default_str();
  command
      ->add_option(
          "--by", a.options.by,
          "vision: a plane's motion; sphere: the camera's rotation, by vision; gyro: its rotation by --imu "
          "alone; both. All but vision need --camera")
      ->check(OneOf({"vision", "sphere", "gyro", "both"}))
      ->capture_default_str();
  command->add_option("--model", a.options.motion.model, "What an image may do from one to the next")
      ->check(OneOf(vision::MotionModelNames()))
      ->capture_default_str();
  command->add_option("--method", a.options.motion.method, "How points are found again")
      ->check(OneOf({"lk", "sift", "surf", "orb"}))
      ->capture_default_str();
  command->add_option("--points", a.options.motion.max_points, "Maximum number of points in an image")
      ->check(WholeNumber(20, 5000))
      ->capture_default_str();
  AddOpenClOption(*command, a.options.motion.opencl);
  command->add_option("--lag-s", a.options.lag_s, "How late the view comes")
      ->check(Within(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--cutoff-hz", a.options.cutoff_hz, "What is faster is taken out of the path")
      ->check(Within(0.05, 5.0))
      ->capture_default_str();
  command->add_option("--crop", a.options.crop, "Share of the image's width and height that is shown")
      ->check(Within(0.2, 1.0))
      ->capture_default_str();
  command->add_flag("--no-scale", a.no_scale, "Do not enlarge what is shown to the image's size");
  command->add_flag("--unbounded", a.unbounded, "Let the view leave the image rather than follow its shakes");
  command->add_option("--border", a.options.border, "What is shown where the image has nothing")
      ->check(OneOf({"black", "blurred", "filled"}))
      ->capture_default_str();
  AddRecordingOptions(*command, a);
  AddCameraOptions(*command, a);
  command
      ->add_option(
          "--level", a.level,
          "skyline: turn the view until the horizon is level, as the skyline shows it; not --by vision")
      ->check(OneOf({"none", "skyline"}))
      ->capture_default_str();
  AddMountOptions(*command, a.mount);
  CLI::Option* imu =
      command
          ->add_option("--imu", a.imu,
                       "CSV of a gyro: t_s, wx_rad_s, wy_rad_s, wz_rad_s in the camera's axes; or "
                       "imu0/data.csv of EuRoC "
                       "or an MCAP, by a calibration with the camera's pose on the IMU (default: that "
                       "of the recording)")
          ->type_name("FILE");
  command->add_option("--imu-topic", a.imu_topic, "Which IMU of an MCAP with several (default: the only one)")
      ->type_name("NAME");
  CLI::Option* offset =
      command
          ->add_option("--imu-offset-s", a.imu_offset_s,
                       "What is to be added to the video's time for the gyro's (default: it is estimated)")
          ->check(Within(-1e10, 1e10))
          ->needs(imu);
  command->add_option("--max-offset-s", a.max_offset_s, "Within which the offset is looked for")
      ->check(Within(0.0, 60.0))
      ->capture_default_str()
      ->needs(imu)
      ->excludes(offset);
  command
      ->add_option(
          "--readout-s", a.readout_s,
          "From the first row's exposure to the last one's, of a rolling shutter; negative: from below")
      ->check(Within(-0.2, 0.2));
  command->add_option("--out", a.out, "The video (.mp4)")->type_name("FILE");
  command
      ->add_option("--before-after", a.before_after,
                   "A video of both side by side, with what was matched drawn (.mp4)")
      ->type_name("FILE");
  command->add_option("--csv", a.csv, "A row for each image: state, points, path")->type_name("FILE");
  AddFramesOption(*command, "images", a.frames);
  AddDeinterlaceOption(*command, a);
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->parse_complete_callback([command, &a] { RefuseUseless(*command, a); });
  command->footer(
      "Exit status 1: no image's motion was measured, or no horizon was seen to be levelled by.\n\n"
      "Examples:\n"
      "  kestrel stabilise flight.mp4 --out steady.mp4 --before-after both.mp4 --csv path.csv\n"
      "  kestrel stabilise EUROC --by gyro --out steady.mp4\n"
      "  kestrel stabilise hover.mp4 --mode reference --border filled --out still.mp4\n"
      "  kestrel stabilise flight.mp4 --by both --imu gyro.csv --camera my_calibration.yaml --readout-s 0.03 "
      "--out "
      "steady.mp4");
  return command;
}

bool StabiliseCommand(const StabiliseArguments& given) {
  StabiliseArguments a = given;
  a.options.scale = !a.no_scale, a.options.bound = !a.unbounded;
  a.options.level = a.level == "skyline";
  Mistakes mistakes;
  stopped = false;
  ImageInput input = OpenImages(a, stopped, mistakes);
  std::error_code none;
  const bool live = !std::filesystem::exists(a.input, none);
  if (input.still && input.size)
    mistakes.Add(a.input, "", "one image, which has no motion", "valid: a video, or a folder of images");
  std::optional<vision::CameraModel> camera;
  const bool has_camera = !a.camera.empty() || input.has_calibration();
  if (!a.camera.empty() || (has_camera && a.options.by != "vision")) camera = ReadCamera(a, input, mistakes);
  if (ByGyro(a) && a.imu.empty()) a.imu = input.gyro.string();
  if (!has_camera && input.next && a.options.by != "vision")
    mistakes.Add("--camera", "", fmt::format("not given, and --by {} needs it", a.options.by),
                 "valid: a calibration file, or --by vision");
  if (a.options.level && a.options.by == "vision")
    mistakes.Add("--level", "", "'skyline' turns the camera's view, which --by vision does not know",
                 "valid: --by sphere, gyro or both");
  if (ByGyro(a) == a.imu.empty())
    mistakes.Add("--imu", "",
                 a.imu.empty() ? fmt::format("not given, and --by {} needs it", a.options.by)
                               : fmt::format("of no use to --by {}", a.options.by),
                 "valid: --by gyro or both, with --imu");
  if (ByGyro(a) && live)
    mistakes.Add("--imu", "", "a file, and the input is a camera that goes on",
                 "valid: with a video or a folder");
  if (a.out.empty() && a.csv.empty() && a.before_after.empty())
    mistakes.Add("--out", "", "not given, nor --csv or --before-after: there would be no result");
  CheckOutputFiles(a, false, a.imu, mistakes);
  if (!a.before_after.empty()) {
    StabiliseArguments other = a;
    other.out = a.before_after;
    CheckOutputFiles(other, false, a.imu, mistakes);
    if (a.before_after == a.out)
      mistakes.Add("--before-after", "", fmt::format("'{}' is that of --out too", a.out),
                   "valid: another file");
  }
  mistakes.ThrowIfAny();
  std::optional<Gyro> gyro;
  if (ByGyro(a)) gyro = OpenGyro(a, *camera, input, stopped, mistakes);
  mistakes.ThrowIfAny();
  if (!a.quiet && !input.note.empty()) fmt::print("{}\n", input.note);
  OnEndSignals([](int) { stopped = true; });
  return StabiliseVideo(a, input, camera, gyro, stopped);
}

}  // namespace kestrel::app
