// SPDX-License-Identifier: Apache-2.0
#include "app/bench_command.h"

#include <filesystem>

#include "bench/bench_attitude.h"
#include "bench/bench_calibration.h"
#include "bench/bench_contrast.h"
#include "bench/bench_flights.h"
#include "bench/bench_render.h"
#include "bench/bench_stream.h"
#include "bench/bench_trackers.h"
#include "bench/bench_wire.h"
#include "bench/horizon/bench_horizon.h"
#include "bench/servo/bench_servo.h"
#include "bench/servo/bench_servoing.h"

namespace kestrel {

std::vector<std::string> BenchNames() {
  return {"flights",  "fisheye", "attitude", "horizon",     "gyro_failure", "drift",
          "heights",  "speed",   "render",   "calibration", "servo",        "trackers",
          "contrast", "follow",  "avoid",    "stream",      "wire",         "link_faults"};
}

bool Bench(const BenchArguments& arguments) {
  const SeedRange seeds = ParseSeeds(arguments.seeds);
  const auto chosen = [&](const char* name) { return arguments.name.empty() || arguments.name == name; };
  std::vector<Figure> table;
  if (chosen("flights")) BenchFlights(seeds, arguments.jobs, table);
  if (chosen("fisheye")) BenchFisheye(seeds, arguments.jobs, table);
  if (chosen("attitude")) BenchAttitude(seeds, arguments.jobs, table);
  if (chosen("horizon")) BenchHorizon(seeds.first, arguments.jobs, arguments.out, table);
  if (chosen("gyro_failure")) BenchGyroFailure(seeds, arguments.jobs, table);
  if (chosen("drift")) BenchDrift(seeds, arguments.jobs, table);
  if (chosen("heights")) BenchHeights(seeds, table);
  if (chosen("speed")) BenchSpeed(seeds, table);
  if (chosen("render")) BenchRender(seeds.first, seeds.last, table);
  if (chosen("calibration")) BenchCalibration(seeds.first, seeds.last, arguments.jobs, table);
  if (chosen("servo")) BenchServo(table);
  if (chosen("trackers")) BenchTrackers(seeds.first, seeds.last, table);
  if (chosen("follow")) BenchFollow(seeds, arguments.jobs, table);
  if (chosen("avoid")) BenchAvoid(seeds, arguments.jobs, table);
  if (chosen("contrast"))
    BenchContrast(seeds.first, seeds.last, arguments.jobs, std::filesystem::path(arguments.out) / "contrast",
                  table);
  if (chosen("stream")) BenchStream(table);
  // By name alone: they need the program for real aircraft, and real time.
  const std::filesystem::path wires = "results/runs";
  if (arguments.name == "wire") BenchWire(seeds, arguments.jobs, wires / "bench_wire", table);
  if (arguments.name == "link_faults")
    BenchLinkFaults(seeds, arguments.jobs, wires / "bench_link_faults", table);
  PrintFigures(table);
  if (!arguments.json.empty()) WriteFigures(arguments.json, table);
  return AllMet(table);
}

}  // namespace kestrel
