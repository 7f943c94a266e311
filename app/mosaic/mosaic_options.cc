// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "app/option/bits_option.h"
#include "app/option/one_of.h"
#include "app/option/opencl_option.h"
#include "app/option/within.h"
#include "app/simulated/images_input.h"
#include "geometry/tait_bryan.h"

namespace kestrel::app {
namespace {

const std::map<std::string, vision::Surface> kSurfaces = {{"plane", vision::Surface::kPlane},
                                                          {"cylinder", vision::Surface::kCylinder},
                                                          {"sphere", vision::Surface::kSphere}};
const std::map<std::string, vision::Blending> kBlendings = {{"average", vision::Blending::kAverage},
                                                            {"feather", vision::Blending::kFeather},
                                                            {"nearest", vision::Blending::kNearest}};
const std::map<std::string, vision::Composer> kComposers = {
    {"average", vision::Composer::kAverage}, {"feather", vision::Composer::kFeather},
    {"nearest", vision::Composer::kNearest}, {"median", vision::Composer::kMedian},
    {"seams", vision::Composer::kSeams},     {"multiband", vision::Composer::kMultiBand}};

template <class T>
std::vector<std::string> NamesOf(const std::map<std::string, T>& all) {
  std::vector<std::string> names;
  for (const auto& [name, value] : all) names.push_back(name);
  return names;
}

std::int64_t HalfOfMemory(const MosaicArguments& a) { return std::int64_t{1'000'000} * a.memory_mb / 2; }

}  // namespace

bool MosaicOnPlane(const MosaicArguments& a) { return a.surface == "plane"; }

std::optional<vision::CameraModel> MosaicCameraOf(const MosaicArguments& a, const ImageInput& input,
                                                  Mistakes& mistakes) {
  if (!a.camera.empty() && a.fov_deg > 0)
    mistakes.Add("--fov-deg", "", "with --camera, which has one", "valid: one of them");
  const bool needed = !MosaicOnPlane(a) || !a.poses.empty();
  const bool of_recording = needed && a.fov_deg == 0 && input.has_calibration();
  if (!a.camera.empty() || of_recording) return ReadCamera(a, input, mistakes);
  if (a.fov_deg > 0 && input.size) {
    const double f_px = input.size->width / 2.0 / std::tan(Radians(a.fov_deg) / 2);
    return vision::Pinhole{.width_px = input.size->width,
                           .height_px = input.size->height,
                           .fx = f_px,
                           .fy = f_px,
                           .cx = (input.size->width - 1) / 2.0,
                           .cy = (input.size->height - 1) / 2.0};
  }
  if (a.fov_deg > 0)
    mistakes.Add("--fov-deg", "", "the size of its images is not known before the first", "valid: --camera");
  else if (!MosaicOnPlane(a))
    mistakes.Add("--surface", "", fmt::format("a {} needs the camera's rays", a.surface),
                 "valid: with --camera or --fov-deg, or plane");
  else if (!a.poses.empty())
    mistakes.Add("--poses", "", "poses need the camera's rays", "valid: with --camera or --fov-deg");
  return std::nullopt;
}

vision::MosaicOptions MosaicOptionsOf(const MosaicArguments& a,
                                      const std::optional<vision::CameraModel>& camera) {
  vision::MosaicOptions options;
  options.model = MosaicOnPlane(a) ? vision::MosaicModel::kPlane : vision::MosaicModel::kRotation;
  options.surface = kSurfaces.at(a.surface);
  options.blending = kBlendings.at(a.blend);
  options.camera = camera;
  options.ground_down_m = a.ground_down_m;
  options.pose_sigma_m = a.pose_sigma_m;
  options.pose_sigma_deg = a.pose_sigma_deg;
  options.keyframe_overlap = a.overlap;
  options.loops = !a.chain;
  options.opencl = a.opencl;
  options.most_bytes = HalfOfMemory(a);
  return options;
}

vision::CompositionOptions MosaicCompositionOf(const MosaicArguments& a) {
  return {.composer = kComposers.at(a.compose), .exposure = !a.no_exposure, .most_bytes = HalfOfMemory(a)};
}

CLI::App* AddMosaicCommand(CLI::App& app, MosaicArguments& a) {
  CLI::App* command = app.add_subcommand("mosaic", "Join the images of a video to one picture");
  command
      ->add_option(
          "input", a.input,
          "A video, a folder of images, a recording (EuRoC, TUM, KITTI, MCAP), or a camera's address, as "
          "of kestrel fly")
      ->type_name("INPUT")
      ->required();
  command
      ->add_option("--out", a.out,
                   "The picture (.png, .jpg); further mosaics, after cuts, are NAME_2 and so on")
      ->type_name("FILE");
  AddRecordingOptions(*command, a);
  AddCameraOptions(*command, a);
  command->add_option("--fov-deg", a.fov_deg, "Without a calibration: the camera's horizontal field of view")
      ->check(Within(5.0, 150.0));
  command
      ->add_option("--surface", a.surface,
                   "plane: the camera moves over flat ground; cylinder, sphere: it turns on the spot")
      ->check(OneOf(NamesOf(kSurfaces)))
      ->capture_default_str();
  command
      ->add_option(
          "--compose", a.compose,
          "How the picture is made when all images have their places. median: what moves vanishes; seams, "
          "multiband: it is cut around")
      ->check(OneOf(NamesOf(kComposers)))
      ->capture_default_str();
  CLI::Option* blend =
      command->add_option("--blend", a.blend, "How images are blended as they come, in --video")
          ->check(OneOf(NamesOf(kBlendings)))
          ->capture_default_str();
  command->add_flag("--no-exposure", a.no_exposure, "Leave the images as bright as they are");
  AddOpenClOption(*command, a.opencl);
  command->add_flag("--chain", a.chain, "Chain images alone, without loops and adjustment");
  command
      ->add_option("--overlap", a.overlap, "An image that shares less with the last keyframe is the next one")
      ->check(Within(0.3, 0.95))
      ->capture_default_str();
  CLI::Option* poses = command
                           ->add_option("--poses", a.poses,
                                        "A CSV file with the aircraft's pose at each image: telemetry.csv of "
                                        "a flight, or columns north_m, "
                                        "east_m, down_m, yaw_deg, pitch_deg, roll_deg")
                           ->type_name("FILE");
  command->add_option("--ground-down-m", a.ground_down_m, "How far below N's origin the ground is")
      ->check(Within(-1e4, 1e4))
      ->capture_default_str();
  command->add_option("--pose-sigma-m", a.pose_sigma_m, "Standard deviation of the poses' positions")
      ->check(Within(1e-3, 100.0))
      ->capture_default_str();
  command->add_option("--pose-sigma-deg", a.pose_sigma_deg, "Standard deviation of their attitudes")
      ->check(Within(1e-3, 45.0))
      ->capture_default_str();
  AddMountOptions(*command, a.mount);
  for (const char* of_poses : {"--ground-down-m", "--pose-sigma-m", "--pose-sigma-deg", "--mount-yaw-deg",
                               "--mount-pitch-deg", "--mount-roll-deg"})
    command->get_option(of_poses)->needs(poses);
  command->add_option("--geotiff", a.geotiff, "The picture as a GeoTIFF (.tif) in metres of N; needs --poses")
      ->type_name("FILE");
  blend->needs(command->add_option("--video", a.video, "Images and the growing mosaic side by side (.mp4)")
                   ->type_name("FILE"));
  command->add_option("--csv", a.csv, "A row for each image: what became of it, and where it lies")
      ->type_name("FILE");
  command->add_option("--memory-mb", a.memory_mb, "Memory for images and mosaic")
      ->check(WholeNumber(50, 1000000))
      ->capture_default_str();
  command->add_option("--every", a.every, "Of so many images one")
      ->check(WholeNumber(1, 10000))
      ->capture_default_str();
  AddFramesOption(*command, "images", a.frames);
  AddDeinterlaceOption(*command, a);
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Exit status 1: no two images were joined, or a GeoTIFF is missing because no image of its mosaic has "
      "a pose.\n\n"
      "Examples:\n"
      "  kestrel mosaic survey.mp4 --out mosaic.png --video growing.mp4 --csv places.csv\n"
      "  kestrel mosaic EUROC --topic cam1 --surface sphere --out panorama.jpg\n"
      "  kestrel mosaic turn.mp4 --surface cylinder --camera thesis_2_8mm --out panorama.jpg\n"
      "  kestrel mosaic flight/recording --poses flight/telemetry.csv --camera thesis_6mm --geotiff "
      "ground.tif");
  return command;
}

}  // namespace kestrel::app
