// SPDX-License-Identifier: Apache-2.0
#include "app/dataset/dataset_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "app/option/one_of.h"
#include "app/option/within.h"
#include "base/stopwatch.h"
#include "flight/dataset/dataset.h"

namespace kestrel::app {

CLI::App* AddDatasetCommand(CLI::App& app, DatasetCommandArguments& a) {
  CLI::App* command =
      app.add_subcommand("dataset", "Make a data set: images, their truth and IMU, as EuRoC, TUM or KITTI");
  flight::DatasetArguments& set = a.set;
  set.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  command
      ->add_option(
          "source", set.source,
          "A scenario, whose mission is flown; or a trajectory: a way (YAML with the key way), or poses as "
          "TUM (.txt) or EuRoC (.csv) has them")
      ->type_name("SCENARIO|TRAJECTORY")
      ->required();
  command->add_option("--format", set.format, "Layout of the data set")
      ->check(OneOf(flight::FormatNames()))
      ->capture_default_str();
  command->add_option("--out", a.out, "Folder of the set; one that was broken off goes on there")
      ->type_name("DIR")
      ->required();
  command->add_option("--count", set.count, "Sequences, of the seed and those after it")
      ->check(WholeNumber(1, 100000))
      ->capture_default_str();
  command->add_option("--frames", set.frames, "Of each sequence, at most")->check(WholeNumber(1, 100000000));
  command->add_option("--duration", set.duration_s, "Of each sequence, at most, s")
      ->check(Within(0.01, 36000.0));
  command->add_option("--seed", a.seed, "Of the first sequence, in place of the scenario's");
  command->add_flag("--colour", set.extras.colour, "Colour images; those of tum always are");
  command->add_flag("--depth", set.extras.depth, "Depth of each image");
  command->add_flag("--flow", set.extras.flow, "Optical flow from each image to the next");
  command->add_flag("--segmentation", set.extras.segmentation, "What each pixel shows, with geoms.csv");
  command->add_flag("--boxes", set.extras.boxes, "Boxes around what is seen of the pad and of targets");
  command->add_option("--in", set.in, "Scenario whose world, camera and pad a trajectory is flown in")
      ->type_name("SCENARIO");
  command->add_option("--world", a.world, "As --set world=WORLD")->type_name("WORLD");
  command->add_option("--camera", a.camera, "As --set camera=CAMERA")->type_name("CAMERA");
  command->add_option("--rate", a.rate_hz, "Images in a second: as --set image.rate_hz=HZ")->type_name("HZ");
  command
      ->add_option("--imu-rate", set.imu_rate_hz,
                   "Readings of the IMU in a second (default: the scenario's; 200 where it has no IMU)")
      ->check(Within(1.0, 1000.0))
      ->type_name("HZ");
  command->add_option("--set", set.overrides, "key.path=value, as for run")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command
      ->add_option("--jobs", set.jobs,
                   "Threads (default: one for each core); the bytes are the same for any number")
      ->check(WholeNumber(1, 256))
      ->type_name("N");
  command->footer(
      "Examples:\n"
      "  kestrel dataset landing --out landing_set --depth --flow --segmentation --boxes\n"
      "  kestrel dataset landing --format kitti --count 10 --duration 20 --out ten_landings\n"
      "  kestrel dataset examples/dataset/round.yaml --world summer_sun --camera fisheye_190 --frames 1000 "
      "--depth "
      "--flow --segmentation --out fisheye_set\n"
      "  kestrel dataset groundtruth.txt --format tum --world room --depth --out room_set");
  return command;
}

void DatasetCommand(const DatasetCommandArguments& a) {
  flight::DatasetArguments set = a.set;
  set.out = a.out;
  std::vector<std::string> shorts;
  if (!a.world.empty()) shorts.push_back("world=" + a.world);
  if (!a.camera.empty()) shorts.push_back("camera=" + a.camera);
  if (a.rate_hz) shorts.push_back(fmt::format("image.rate_hz={}", *a.rate_hz));
  if (a.seed) shorts.push_back(fmt::format("seed={}", *a.seed));
  set.overrides.insert(set.overrides.begin(), shorts.begin(), shorts.end());
  const auto start = std::chrono::steady_clock::now();
  const flight::DatasetResult result = flight::MakeDataset(flight::LoadDatasetPlan(set));
  if (result.found > 0) fmt::print("{} of {} frames were there already\n", result.found, result.frames);
  fmt::print("{} frames in {}, {} files of {:.0f} MB, in {:.1f} s\n{}\n", result.frames,
             result.sequences == 1 ? "a sequence" : fmt::format("{} sequences", result.sequences),
             result.files, static_cast<double>(result.bytes) / 1e6, SecondsSince(start), a.out);
}

}  // namespace kestrel::app
