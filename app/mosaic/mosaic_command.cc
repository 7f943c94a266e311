// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <utility>

#include "app/mosaic/mosaic_files.h"
#include "app/mosaic/mosaic_options.h"
#include "app/mosaic/mosaic_report.h"
#include "app/mosaic/mosaic_view.h"
#include "app/mosaic/pose_table.h"
#include "app/simulated/images_input.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/process/end_signals.h"
#include "base/stopwatch.h"
#include "vision/enhance/canvas/geotiff.h"
#include "vision/enhance/motion/point_flow.h"

namespace kestrel::app {
namespace {

std::atomic<bool> stopped = false;

// The poses of the camera at its images.
std::vector<std::optional<Pose>> PosesOf(const MosaicArguments& a, Mistakes& mistakes) {
  if (a.poses.empty()) return {};
  std::vector<std::optional<Pose>> poses = ReadPoseTable(a.poses, mistakes);
  const Pose X_BC = PoseOf(a.mount);
  for (auto& pose : poses)
    if (pose) pose = *pose * X_BC;
  const auto is_above = [&](const auto& pose) { return pose && pose->p.z() < a.ground_down_m; };
  if (!poses.empty() && MosaicOnPlane(a) && std::none_of(poses.begin(), poses.end(), is_above))
    mistakes.Add(
        a.poses, "",
        fmt::format("no pose is above the ground, which is {:g} m below N's origin", a.ground_down_m),
        "valid: poses of a flight, down_m less than --ground-down-m");
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
  if (!a.geotiff.empty() && (a.poses.empty() || !MosaicOnPlane(a)))
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

// Why the mosaic of this step is another than the one before.
std::string WhyAnother(const vision::MosaicSeries::Step& step) {
  using Cause = vision::MosaicSeries::Cause;
  if (step.cause == Cause::kResized) return "resized";
  if (step.cause == Cause::kLost) return fmt::format("lost for {} images", step.lost);
  return "cut";
}

// Every image, as it comes.
MosaicCount AddAll(const MosaicArguments& a, ImageInput& input, const std::vector<std::optional<Pose>>& poses,
                   vision::MosaicSeries& series, std::vector<double>& times_s) {
  MosaicCount count;
  FrameProgress progress(!a.quiet);
  std::optional<records::Video> video;
  if (!a.video.empty()) video.emplace(a.video, input.rate_hz);
  try {
    for (int number = 0; !stopped && (a.frames == 0 || count.frames < a.frames); ++number) {
      auto start = std::chrono::steady_clock::now();
      const auto frame = NextImage(input, number, a.quiet);
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
      count.below_ground += pose && MosaicOnPlane(a) && pose->p.z() >= a.ground_down_m;
      if (!frame->image.empty()) count.interlace.Add(frame->image);
      start = std::chrono::steady_clock::now();
      const vision::MosaicSeries::Step step = series.Add(frame->image, frame->t_s, pose);
      count.add_s += SecondsSince(start);
      times_s.push_back(frame->t_s);
      ++count.frames;
      count.against_pose += step.step.against_pose;
      if (step.cause != vision::MosaicSeries::Cause::kNone && !a.quiet)
        fmt::print("{}: mosaic {} began {} images before the one at {:.2f} s\n", WhyAnother(step),
                   step.mosaic + 1, vision::MosaicSeries::kCut - 1, frame->t_s);
      if (video && !frame->image.empty())
        video->Write(MosaicView(step, series.mosaic(step.mosaic), frame->image));
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

}  // namespace

bool MosaicCommand(const MosaicArguments& a) {
  Mistakes mistakes;
  CheckFiles(a, mistakes);
  stopped = false;
  ImageInput input = OpenImages(a, stopped, mistakes);
  const std::optional<vision::CameraModel> camera = MosaicCameraOf(a, input, mistakes);
  const std::vector<std::optional<Pose>> poses = PosesOf(a, mistakes);
  mistakes.ThrowIfAny();
  OnEndSignals([](int) { stopped = true; });
  const vision::MosaicOptions options = MosaicOptionsOf(a, camera);
  if (!a.quiet && !input.note.empty()) fmt::print("{}\n", input.note);
  if (!a.quiet && input.size) fmt::print("{}", MosaicMemory(a.memory_mb, options, *input.size));

  vision::MosaicSeries series(options);
  std::vector<double> times_s;
  MosaicCount count = AddAll(a, input, poses, series, times_s);
  const auto start = std::chrono::steady_clock::now();
  series.Finish();
  for (const auto& place : series.places()) {
    count.placed += vision::IsPlaced(place.step.state);
    ++count.of_state[vision::NameOf(place.step.state)];
  }
  std::vector<std::string> sentences;
  bool whole = true;
  const vision::CompositionOptions composition = MosaicCompositionOf(a);
  for (int i = 0; i < series.mosaics(); ++i) {
    WrittenMosaic written = WriteMosaic(series.mosaic(i), i, composition, a.out, a.geotiff);
    whole &= written.whole;
    if (!written.sentence.empty()) sentences.push_back(std::move(written.sentence));
  }
  if (!a.csv.empty()) WriteFile(a.csv, MosaicTable(series, times_s, vision::FlowDevice(a.opencl)));
  if (!a.quiet) fmt::print("{}", MosaicReport(a, count, SecondsSince(start), sentences));
  if (!count.broke_off.empty())
    throw std::runtime_error(fmt::format("{}: it broke off after {} images, whose mosaic is written: {}",
                                         a.input, count.frames, count.broke_off));
  return count.joined() > 0 && whole;
}

}  // namespace kestrel::app
