// SPDX-License-Identifier: Apache-2.0
#include "app/bench_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <vector>

#include "app/option/one_of.h"
#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/file/model_files.h"
#include "bench/alignment/bench_alignment.h"
#include "bench/alignment/bench_pad_trackers.h"
#include "bench/bench_attitude.h"
#include "bench/bench_calibration.h"
#include "bench/bench_campaign.h"
#include "bench/bench_contrast.h"
#include "bench/bench_flights.h"
#include "bench/bench_hashes.h"
#include "bench/bench_stream.h"
#include "bench/bench_trackers.h"
#include "bench/bench_wire.h"
#include "bench/enhance/bench_mosaic.h"
#include "bench/enhance/bench_stabilise.h"
#include "bench/horizon/bench_horizon.h"
#include "bench/horizon/bench_photographs.h"
#include "bench/horizon/border_training.h"
#include "bench/landmark/bench_features.h"
#include "bench/landmark/bench_homographies.h"
#include "bench/landmark/bench_landings.h"
#include "bench/landmark/bench_plane_pose.h"
#include "bench/limits/bench_limits.h"
#include "bench/live/bench_live.h"
#include "bench/lockstep/bench_lockstep.h"
#include "bench/planar/bench_planar.h"
#include "bench/render/bench_frames.h"
#include "bench/render/bench_render.h"
#include "bench/servo/bench_servo.h"
#include "bench/servo/bench_servo_flights.h"
#include "bench/servo/bench_servoing.h"
#include "bench/throughput/bench_throughput.h"
#include "bench/timings/bench_timings.h"
#include "bench/timings/timing_server.h"

namespace kestrel::app {
namespace {

bool Timings(const BenchArguments& a) {
  if (a.in_turn) {
    bench::ServeTimings(std::cin, std::cout);
    return true;
  }
  const auto clock = a.clock == "wall" ? bench::TimingClock::kWall : bench::TimingClock::kProcessor;
  return bench::BenchTimings({.rounds = a.rounds, .clock = clock, .against = a.against, .json = a.json});
}

}  // namespace

CLI::App* AddBenchCommand(CLI::App& app, BenchArguments& a) {
  const std::vector<std::string> names = {"flights",
                                          "fisheye",
                                          "attitude",
                                          "horizon",
                                          "gyro_failure",
                                          "drift",
                                          "heights",
                                          "speed",
                                          "render",
                                          "calibration",
                                          "servo",
                                          "trackers",
                                          "contrast",
                                          "follow",
                                          "avoid",
                                          "stream",
                                          "planar",
                                          "alignment",
                                          "features",
                                          "homographies",
                                          "plane_pose",
                                          "landings",
                                          "servo_flights",
                                          "direct",
                                          "mosaic",
                                          "stabilise",
                                          "follow_thesis",
                                          "avoid_thesis",
                                          "wire",
                                          "link_faults",
                                          "campaign",
                                          "hashes",
                                          "lockstep",
                                          "frames",
                                          "live",
                                          "horizon_pictures",
                                          "horizon_training",
                                          "timings",
                                          "throughput",
                                          "limits"};
  CLI::App* command = app.add_subcommand("bench", "Measure: a table of figures beside their targets");
  // Of campaigns by its name alone: it flies for minutes, and kills itself.
  command
      ->add_option("name", a.name,
                   "All but campaign, wire, link_faults, hashes, lockstep, frames, live, horizon_pictures, "
                   "horizon_training, timings, throughput and limits when none is given")
      ->check(OneOf(names));
  command
      ->add_option("pictures", a.pictures,
                   "Of horizon_pictures and horizon_training: a folder of photographs, with label.csv "
                   "(filename,slope,offset; none,none where no horizon is in view) or without")
      ->type_name("DIR");
  command
      ->add_option("--fov-deg", a.fov_deg,
                   "Of horizon_pictures and horizon_training: what the longer side of the photographs sees")
      ->check(CLI::Range(5.0, 120.0))
      ->capture_default_str();
  command->add_option("--seeds", a.seeds, "A..B, first and last")->capture_default_str();
  command->add_option("--jobs", a.jobs, "Flights at the same time")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--json", a.json, "Also write the figures as JSON to this file")->type_name("FILE");
  command
      ->add_option("--out", a.out,
                   "Folder for the rows and pictures of horizon, and for the pictures of frames and of "
                   "contrast's failures")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_option("--backend", a.backend, "What OpenGL draws by in render and frames")
      ->check(OneOf({"osmesa", "egl"}))
      ->capture_default_str();
  command
      ->add_option(
          "--against", a.against,
          "Of timings: what to compare with. A program kestrel of another build, which runs in turn "
          "with this one and shows 5 %; or what --json wrote on this machine before, which shows less")
      ->check([](const std::string& file) {
        return file.empty() ? "no file; valid: a program kestrel, or what --json wrote" : "";
      })
      ->type_name("FILE");
  command
      ->add_option("--rounds", a.rounds,
                   "Of timings: processes of each program that are timed; of fewer nothing follows")
      ->check(CLI::Range(9, 200))
      ->capture_default_str();
  command
      ->add_option("--clock", a.clock,
                   "Of timings: the processor's time of all threads, or the wall's, which has what else the "
                   "machine does in it")
      ->check(OneOf({"processor", "wall"}))
      ->capture_default_str();
  command
      ->add_flag("--in-turn", a.in_turn,
                 "Of timings: answer another program, that reads names of work from here line by line")
      ->group("");
  command->footer(
      "Examples:\n  kestrel bench flights --seeds 1..20\n  kestrel bench render\n"
      "  kestrel bench timings --against build-before/kestrel");
  return command;
}

bool BenchCommand(const BenchArguments& arguments) {
  Mistakes mistakes;
  CheckWritableFile(arguments.json, "--json", mistakes);
  if (arguments.name.empty() || arguments.name == "horizon" || arguments.name == "frames")
    CheckWritableFolder(arguments.out, "--out", mistakes);
  const bool of_training = arguments.name == "horizon_training";
  const bool of_photographs = of_training || arguments.name == "horizon_pictures";
  std::vector<bench::Photograph> photographs;
  if (of_photographs) photographs = bench::ReadPhotographs(arguments.pictures, mistakes);
  if (!of_photographs && !arguments.pictures.empty())
    mistakes.Add("bench", arguments.name, arguments.pictures,
                 "valid: a folder after horizon_pictures or horizon_training alone");
  if (of_training && !photographs.empty() &&
      std::none_of(photographs.begin(), photographs.end(), [](const auto& p) { return p.labelled; }))
    mistakes.Add("bench", arguments.name, "no photograph there has a label",
                 "valid: a folder with label.csv (filename,slope,offset)");
  const bool of_timings = arguments.name == "timings";
  if (!of_timings && !arguments.against.empty())
    mistakes.Add("bench", arguments.name, "has nothing to compare --against",
                 "valid: bench timings --against FILE");
  mistakes.ThrowIfAny();
  if (of_timings) return Timings(arguments);
  if (arguments.name == "throughput" || arguments.name == "limits") {  // tables of their own
    std::vector<records::Figure> figures;
    if (arguments.name == "throughput")
      bench::BenchThroughput("results/runs/bench_throughput", figures);
    else
      bench::BenchLimits(figures);
    if (!arguments.json.empty()) records::WriteFigures(arguments.json, figures);
    return true;
  }
  const flight::SeedRange seeds = flight::ParseSeeds(arguments.seeds);
  const auto chosen = [&](const char* name) { return arguments.name.empty() || arguments.name == name; };
  std::vector<records::Figure> table;
  if (chosen("flights")) bench::BenchFlights(seeds, arguments.jobs, table);
  if (chosen("fisheye")) bench::BenchFisheye(seeds, arguments.jobs, table);
  if (chosen("landings")) bench::BenchLandings(seeds, arguments.jobs, table);
  if (chosen("attitude")) bench::BenchAttitude(seeds, arguments.jobs, table);
  if (chosen("horizon")) bench::BenchHorizon(seeds.first, arguments.jobs, arguments.out, table);
  if (chosen("gyro_failure")) bench::BenchGyroFailure(seeds, arguments.jobs, table);
  if (chosen("drift")) bench::BenchDrift(seeds, arguments.jobs, table);
  if (chosen("heights")) bench::BenchHeights(seeds, table);
  if (chosen("speed")) bench::BenchSpeed(seeds, table);
  if (chosen("render")) bench::BenchRender(seeds.first, seeds.last, arguments.backend, table);
  if (chosen("calibration")) bench::BenchCalibration(seeds.first, seeds.last, arguments.jobs, table);
  if (chosen("servo")) bench::BenchServo(table);
  if (chosen("servo_flights")) bench::BenchServoFlights(seeds, arguments.jobs, table);
  if (chosen("direct")) bench::BenchDirect(seeds, arguments.jobs, table);
  if (chosen("trackers")) {
    bench::BenchTrackers(seeds.first, seeds.last, table);
    bench::BenchPadTrackers(seeds, table);
  }
  if (chosen("alignment")) bench::BenchAlignment(seeds, table);
  if (chosen("follow")) bench::BenchFollow(seeds, arguments.jobs, table);
  if (chosen("follow_thesis")) bench::BenchFollowSteps(seeds, arguments.jobs, table);
  if (chosen("avoid_thesis")) bench::BenchAvoidSight(seeds, arguments.jobs, table);
  if (chosen("avoid")) bench::BenchAvoid(seeds, arguments.jobs, table);
  if (chosen("contrast"))
    bench::BenchContrast(seeds.first, seeds.last, arguments.jobs,
                         std::filesystem::path(arguments.out) / "contrast", table);
  if (chosen("planar"))
    bench::BenchPlanar(seeds, arguments.jobs, std::filesystem::path(arguments.out) / "planar",
                       bench::PlanarTrackers, table);
  if (chosen("stabilise"))
    bench::BenchStabilise(seeds, std::filesystem::path(arguments.out) / "stabilise", table);
  if (chosen("mosaic")) bench::BenchMosaic(seeds, std::filesystem::path(arguments.out) / "mosaic", table);
  if (chosen("stream")) bench::BenchStream(table);
  if (chosen("features")) bench::BenchFeatures(seeds.first, seeds.last, table);
  if (chosen("homographies")) bench::BenchHomographies(seeds.first, table);
  if (chosen("plane_pose")) bench::BenchPlanePose(seeds.first, table);
  // By name alone: they need the program for real aircraft, and real time.
  const std::filesystem::path wires = "results/runs";
  if (arguments.name == "wire") bench::BenchWire(seeds, arguments.jobs, wires / "bench_wire", table);
  if (arguments.name == "link_faults")
    bench::BenchLinkFaults(seeds, arguments.jobs, wires / "bench_link_faults", table);
  // By name alone: they take long, and are asked for by who changes what they measure.
  if (arguments.name == "campaign")
    bench::BenchCampaign(static_cast<int>(seeds.last - seeds.first) + 1, wires / "bench_campaign", table);
  if (of_training) {
    bench::TrainBorderBelief(photographs, arguments.fov_deg, seeds.first, arguments.jobs, table);
  } else if (of_photographs) {
    bench::BenchPhotographs(photographs, arguments.fov_deg,
                            std::filesystem::path(arguments.out) / "photographs", table);
  }
  if (arguments.name == "lockstep") bench::BenchLockstep(table);
  if (arguments.name == "live") bench::BenchLive(seeds, wires / "bench_live", table);
  if (arguments.name == "frames")
    bench::BenchFrames(seeds.first, seeds.last, arguments.jobs, arguments.backend,
                       std::filesystem::path(arguments.out) / "frames", table);
  if (arguments.name == "hashes")
    bench::BenchHashes(seeds, arguments.jobs, Root() / "results" / "hashes.csv", table);
  records::PrintFigures(table);
  if (!arguments.json.empty()) records::WriteFigures(arguments.json, table);
  return records::AllMet(table);
}

}  // namespace kestrel::app
