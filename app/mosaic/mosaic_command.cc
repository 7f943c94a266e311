// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "app/mosaic/mosaic_files.h"
#include "app/mosaic/mosaic_view.h"
#include "app/mosaic/pose_table.h"
#include "app/option/bits_option.h"
#include "app/option/one_of.h"
#include "app/option/opencl_option.h"
#include "app/simulated/images_input.h"
#include "app/simulated/interlace_watch.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/end_signals.h"
#include "base/stopwatch.h"
#include "geometry/tait_bryan.h"
#include "vision/enhance/canvas/geotiff.h"
#include "vision/enhance/motion/point_flow.h"

namespace kestrel::app {
namespace {

std::atomic<bool> stopped = false;

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

bool OnPlane(const MosaicArguments& a) { return a.surface == "plane"; }

// From a file, or a pinhole by its field of view, or none.
std::optional<vision::CameraModel> CameraOf(const MosaicArguments& a, const ImageInput& input,
                                            Mistakes& mistakes) {
  if (!a.camera.empty() && a.fov_deg > 0)
    mistakes.Add("--fov-deg", "", "with --camera, which has one", "valid: one of them");
  if (!a.camera.empty()) return ReadCamera(a, input.size, mistakes);
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
  else if (!OnPlane(a))
    mistakes.Add("--surface", "", fmt::format("a {} needs the camera's rays", a.surface),
                 "valid: with --camera or --fov-deg, or plane");
  else if (!a.poses.empty())
    mistakes.Add("--poses", "", "poses need the camera's rays", "valid: with --camera or --fov-deg");
  return std::nullopt;
}

vision::MosaicOptions OptionsOf(const MosaicArguments& a, const std::optional<vision::CameraModel>& camera) {
  vision::MosaicOptions options;
  options.model = OnPlane(a) ? vision::MosaicModel::kPlane : vision::MosaicModel::kRotation;
  options.surface = kSurfaces.at(a.surface);
  options.blending = kBlendings.at(a.blend);
  options.camera = camera;
  options.ground_down_m = a.ground_down_m;
  options.pose_sigma_m = a.pose_sigma_m;
  options.pose_sigma_deg = a.pose_sigma_deg;
  options.keyframe_overlap = a.overlap;
  options.loops = !a.chain;
  options.opencl = a.opencl;
  options.most_bytes = std::int64_t{1'000'000} * a.memory_mb / 2;  // the other half composes it
  return options;
}

// The poses of the camera at its images.
std::vector<std::optional<Pose>> PosesOf(const MosaicArguments& a, Mistakes& mistakes) {
  if (a.poses.empty()) return {};
  std::vector<std::optional<Pose>> poses = ReadPoseTable(a.poses, mistakes);
  const Pose X_BC = PoseOf(a.mount);
  for (auto& pose : poses)
    if (pose) pose = *pose * X_BC;
  return poses;
}

void CheckFiles(const MosaicArguments& a, Mistakes& mistakes) {
  const std::vector<std::pair<const char*, std::string>> written = {
      {"--out", a.out}, {"--csv", a.csv}, {"--geotiff", a.geotiff}, {"--video", a.video}};
  if (a.out.empty() && a.geotiff.empty())
    mistakes.Add("--out", "", "not given", "valid: a picture (.png, .jpg), or --geotiff");
  if (!a.out.empty() && !HasEnding(a.out, {".png", ".jpg", ".jpeg"}))
    mistakes.Add("--out", "", fmt::format("'{}' does not name an image", a.out),
                 "valid: an ending .png or .jpg");
  if (!a.video.empty() && !HasEnding(a.video, {".mp4"}))
    mistakes.Add("--video", "", fmt::format("'{}' does not name a video", a.video), "valid: an ending .mp4");
  if (!a.geotiff.empty() && !HasEnding(a.geotiff, {".tif", ".tiff"}))
    mistakes.Add("--geotiff", "", fmt::format("'{}' does not name a TIFF", a.geotiff),
                 "valid: an ending .tif");
  if (!a.geotiff.empty() && !vision::GeoTiffIsAvailable())
    mistakes.Add("--geotiff", "", "this build has no GeoTIFF", "valid: install libtiff-dev and build again");
  if (!a.geotiff.empty() && (a.poses.empty() || !OnPlane(a)))
    mistakes.Add("--geotiff", "", "where a mosaic lies on the ground is known by poses, on a plane",
                 "valid: with --poses, and --surface plane");
  for (std::size_t i = 0; i < written.size(); ++i) {
    const auto& [option, file] = written[i];
    if (file.empty()) continue;
    CheckWritableFile(file, option, mistakes);
    for (const std::string& taken : {a.input, a.camera, a.poses})
      if (!taken.empty() && SameFile(file, taken))
        mistakes.Add(option, "", fmt::format("'{}' is read", file), "valid: another file");
    for (std::size_t k = 0; k < i; ++k)
      if (written[k].second == file)
        mistakes.Add(option, "", fmt::format("'{}' is that of {} too", file, written[k].first),
                     "valid: another file");
  }
}

// What becomes of memory is said before it is used.
void TellOfMemory(const MosaicArguments& a, const vision::MosaicOptions& options, const cv::Size& size) {
  fmt::print(
      "memory {} MB: up to {} images are kept, of those that come after none has a place; beyond {} "
      "megapixels the mosaic is scaled down\n",
      a.memory_mb, vision::Mosaic::MostKept(options, size, 3),
      vision::Mosaic::MostPixels(options, 3) / 1'000'000);
}

struct Count {
  InterlaceWatch interlace;
  int frames = 0, placed = 0, without_pose = 0, poses_over = 0;
  double read_s = 0, add_s = 0;
  std::map<std::string, int> of_state;
  std::string broke_off;
};

// Every image, as it comes.
Count AddAll(const MosaicArguments& a, ImageInput& input, const std::vector<std::optional<Pose>>& poses,
             vision::MosaicSeries& series, std::vector<double>& times_s) {
  Count count;
  FrameProgress progress(!a.quiet);
  std::optional<records::Video> video;
  if (!a.video.empty()) video.emplace(a.video, input.rate_hz);
  try {
    for (int number = 0; !stopped && (a.frames == 0 || count.frames < a.frames); ++number) {
      auto start = std::chrono::steady_clock::now();
      const auto frame = input.next();
      count.read_s += SecondsSince(start);
      if (!frame) {
        count.poses_over = std::max(0, static_cast<int>(poses.size()) - number);
        break;
      }
      if (number % a.every != 0) continue;
      const auto pose = static_cast<std::size_t>(number) < poses.size()
                            ? poses[static_cast<std::size_t>(number)]
                            : std::nullopt;
      count.without_pose += !a.poses.empty() && !pose;
      count.interlace.Add(frame->image);
      start = std::chrono::steady_clock::now();
      const vision::MosaicSeries::Step step = series.Add(frame->image, frame->t_s, pose);
      count.add_s += SecondsSince(start);
      times_s.push_back(frame->t_s);
      ++count.frames;
      if (step.cut && !a.quiet)
        fmt::print("cut: mosaic {} began {} images before the one at {:.2f} s\n", step.mosaic + 1,
                   vision::MosaicSeries::kCut - 1, frame->t_s);
      if (video) video->Write(MosaicView(step, series.mosaic(step.mosaic), frame->image));
      progress.Show(count.frames);
    }
  } catch (const std::runtime_error& e) {
    count.broke_off = e.what();
  }
  progress.Clear();
  try {
    if (video) video->Close();
  } catch (const std::runtime_error& e) {
    if (count.broke_off.empty()) count.broke_off = e.what();
  }
  return count;
}

void Tell(const MosaicArguments& a, const Count& count, double compose_s,
          const std::vector<std::string>& written) {
  std::string states;
  for (const auto& [state, n] : count.of_state) states += fmt::format(", {} {}", n, state);
  fmt::print("{} images, {} in a mosaic{}\n", count.frames, count.placed, states);
  if (a.opencl) fmt::print("points were followed on {}\n", vision::FlowDevice(true));
  if (count.without_pose > 0) fmt::print("{} images have no pose in {}\n", count.without_pose, a.poses);
  if (count.poses_over > 0)
    fmt::print("{} poses are left over in {}: is it of these images?\n", count.poses_over, a.poses);
  if (const std::string interlaced = count.interlace.Sentence(a.input); !interlaced.empty())
    fmt::print("{}\n", interlaced);
  for (const std::string& sentence : written) fmt::print("{}\n", sentence);
  if (count.frames > 0)
    fmt::print("per image: reading {:.1f} ms, adding {:.1f} ms; adjusting and composing {:.1f} s\n",
               1e3 * count.read_s / count.frames, 1e3 * count.add_s / count.frames, compose_s);
}

}  // namespace

CLI::App* AddMosaicCommand(CLI::App& app, MosaicArguments& a) {
  CLI::App* command = app.add_subcommand("mosaic", "Join the images of a video to one picture");
  command
      ->add_option("input", a.input, "A video, a folder of images, or a camera's address, as of kestrel fly")
      ->type_name("INPUT")
      ->required();
  command
      ->add_option("--out", a.out,
                   "The picture (.png, .jpg); further mosaics, after cuts, are NAME_2 and so on")
      ->type_name("FILE");
  AddCameraOptions(*command, a);
  command->add_option("--fov-deg", a.fov_deg, "Without a calibration: the camera's horizontal field of view")
      ->check(CLI::Range(5.0, 150.0));
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
  command->add_option("--blend", a.blend, "How images are blended as they come, in --video")
      ->check(OneOf(NamesOf(kBlendings)))
      ->capture_default_str();
  command->add_flag("--no-exposure", a.no_exposure, "Leave the images as bright as they are");
  AddOpenClOption(*command, a.opencl);
  command->add_flag("--chain", a.chain, "Chain images alone, without loops and adjustment");
  command
      ->add_option("--overlap", a.overlap, "An image that shares less with the last keyframe is the next one")
      ->check(CLI::Range(0.3, 0.95))
      ->capture_default_str();
  command
      ->add_option(
          "--poses", a.poses,
          "A CSV file with the aircraft's pose at each image: telemetry.csv of a flight, or columns north_m, "
          "east_m, down_m, yaw_deg, pitch_deg, roll_deg")
      ->type_name("FILE");
  command->add_option("--ground-down-m", a.ground_down_m, "How far below N's origin the ground is")
      ->check(CLI::Range(-1e4, 1e4))
      ->capture_default_str();
  command->add_option("--pose-sigma-m", a.pose_sigma_m, "Standard deviation of the poses' positions")
      ->check(CLI::Range(1e-3, 100.0))
      ->capture_default_str();
  command->add_option("--pose-sigma-deg", a.pose_sigma_deg, "Standard deviation of their attitudes")
      ->check(CLI::Range(1e-3, 45.0))
      ->capture_default_str();
  AddMountOptions(*command, a.mount);
  command->add_option("--geotiff", a.geotiff, "The picture as a GeoTIFF (.tif) in metres of N; needs --poses")
      ->type_name("FILE");
  command->add_option("--video", a.video, "Images and the growing mosaic side by side (.mp4)")
      ->type_name("FILE");
  command->add_option("--csv", a.csv, "A row for each image: what became of it, and where it lies")
      ->type_name("FILE");
  command->add_option("--memory-mb", a.memory_mb, "Memory for images and mosaic")
      ->check(CLI::Range(50, 1000000))
      ->capture_default_str();
  command->add_option("--every", a.every, "Of so many images one")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  AddFramesOption(*command, "images", a.frames);
  AddDeinterlaceOption(*command, a);
  AddBitsOption(*command, a.bits);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "Examples:\n"
      "  kestrel mosaic survey.mp4 --out mosaic.png --video growing.mp4 --csv places.csv\n"
      "  kestrel mosaic turn.mp4 --surface cylinder --camera thesis_2_8mm --out panorama.jpg\n"
      "  kestrel mosaic flight/recording --poses flight/telemetry.csv --camera thesis_6mm --geotiff "
      "ground.tif");
  return command;
}

bool MosaicCommand(const MosaicArguments& a) {
  Mistakes mistakes;
  CheckFiles(a, mistakes);
  stopped = false;
  ImageInput input = OpenImages(a, stopped, mistakes);
  const std::optional<vision::CameraModel> camera = CameraOf(a, input, mistakes);
  const std::vector<std::optional<Pose>> poses = PosesOf(a, mistakes);
  mistakes.ThrowIfAny();
  OnEndSignals([](int) { stopped = true; });
  const vision::MosaicOptions options = OptionsOf(a, camera);
  if (!a.quiet && !input.note.empty()) fmt::print("{}\n", input.note);
  if (!a.quiet && input.size) TellOfMemory(a, options, *input.size);

  vision::MosaicSeries series(options);
  std::vector<double> times_s;
  Count count = AddAll(a, input, poses, series, times_s);
  const auto start = std::chrono::steady_clock::now();
  series.Finish();
  for (const auto& place : series.places()) {
    count.placed += vision::IsPlaced(place.step.state);
    ++count.of_state[vision::NameOf(place.step.state)];
  }
  std::vector<std::string> written;
  const vision::CompositionOptions composition{
      .composer = kComposers.at(a.compose), .exposure = !a.no_exposure, .most_bytes = options.most_bytes};
  for (int i = 0; i < series.mosaics(); ++i)
    if (std::string sentence = WriteMosaic(series.mosaic(i), i, composition, a.out, a.geotiff);
        !sentence.empty())
      written.push_back(std::move(sentence));
  if (!a.csv.empty()) WriteFile(a.csv, MosaicTable(series, times_s, vision::FlowDevice(a.opencl)));
  if (!a.quiet) Tell(a, count, SecondsSince(start), written);
  if (!count.broke_off.empty())
    throw std::runtime_error(fmt::format("{}: it broke off after {} images, whose mosaic is written: {}",
                                         a.input, count.frames, count.broke_off));
  return count.placed > 0;
}

}  // namespace kestrel::app
