// SPDX-License-Identifier: Apache-2.0
#include "app/bench_command.h"

#include <filesystem>

#include "base/file/model_files.h"
#include "bench/bench_attitude.h"
#include "bench/bench_calibration.h"
#include "bench/bench_campaign.h"
#include "bench/bench_contrast.h"
#include "bench/bench_flights.h"
#include "bench/bench_hashes.h"
#include "bench/bench_render.h"
#include "bench/bench_stream.h"
#include "bench/bench_trackers.h"
#include "bench/bench_wire.h"
#include "bench/horizon/bench_horizon.h"
#include "bench/servo/bench_servo.h"
#include "bench/servo/bench_servoing.h"

namespace kestrel::app {

std::vector<std::string> BenchNames() {
  return {"flights", "fisheye", "attitude",    "horizon",     "gyro_failure", "drift",    "heights",
          "speed",   "render",  "calibration", "servo",       "trackers",     "contrast", "follow",
          "avoid",   "stream",  "wire",        "link_faults", "campaign",     "hashes"};
}

bool Bench(const BenchArguments& arguments) {
  const flight::SeedRange seeds = flight::ParseSeeds(arguments.seeds);
  const auto chosen = [&](const char* name) { return arguments.name.empty() || arguments.name == name; };
  std::vector<records::Figure> table;
  if (chosen("flights")) bench::BenchFlights(seeds, arguments.jobs, table);
  if (chosen("fisheye")) bench::BenchFisheye(seeds, arguments.jobs, table);
  if (chosen("attitude")) bench::BenchAttitude(seeds, arguments.jobs, table);
  if (chosen("horizon")) bench::BenchHorizon(seeds.first, arguments.jobs, arguments.out, table);
  if (chosen("gyro_failure")) bench::BenchGyroFailure(seeds, arguments.jobs, table);
  if (chosen("drift")) bench::BenchDrift(seeds, arguments.jobs, table);
  if (chosen("heights")) bench::BenchHeights(seeds, table);
  if (chosen("speed")) bench::BenchSpeed(seeds, table);
  if (chosen("render")) bench::BenchRender(seeds.first, seeds.last, table);
  if (chosen("calibration")) bench::BenchCalibration(seeds.first, seeds.last, arguments.jobs, table);
  if (chosen("servo")) bench::BenchServo(table);
  if (chosen("trackers")) bench::BenchTrackers(seeds.first, seeds.last, table);
  if (chosen("follow")) bench::BenchFollow(seeds, arguments.jobs, table);
  if (chosen("avoid")) bench::BenchAvoid(seeds, arguments.jobs, table);
  if (chosen("contrast"))
    bench::BenchContrast(seeds.first, seeds.last, arguments.jobs,
                         std::filesystem::path(arguments.out) / "contrast", table);
  if (chosen("stream")) bench::BenchStream(table);
  // By name alone: they need the program for real aircraft, and real time.
  const std::filesystem::path wires = "results/runs";
  if (arguments.name == "wire") bench::BenchWire(seeds, arguments.jobs, wires / "bench_wire", table);
  if (arguments.name == "link_faults")
    bench::BenchLinkFaults(seeds, arguments.jobs, wires / "bench_link_faults", table);
  // By name alone: they take long, and are asked for by who changes what they measure.
  if (arguments.name == "campaign")
    bench::BenchCampaign(static_cast<int>(seeds.last - seeds.first) + 1, wires / "bench_campaign", table);
  if (arguments.name == "hashes")
    bench::BenchHashes(seeds, arguments.jobs, Root() / "results" / "hashes.csv", table);
  records::PrintFigures(table);
  if (!arguments.json.empty()) records::WriteFigures(arguments.json, table);
  return records::AllMet(table);
}

}  // namespace kestrel::app
