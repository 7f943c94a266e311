// SPDX-License-Identifier: Apache-2.0
#include "app/bench/bench_list.h"

#include <algorithm>

#include "app/bench/bench_command.h"
#include "base/file/data_folders.h"
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

namespace kestrel::app {
namespace {

using In = const BenchInput&;
using Table = std::vector<records::Figure>&;
using enum Bench::Kind;

std::vector<Bench> MakeBenches() {
  const std::vector<std::string> by_seeds = {"--seeds"}, by_flights = {"--seeds", "--jobs"},
                                 by_files = {"--seeds", "--out"}, by_all = {"--seeds", "--jobs", "--out"};
  return {
      {"flights", kGeneral, by_flights, [](In i, Table t) { bench::BenchFlights(i.seeds, i.jobs(), t); }},
      {"fisheye", kGeneral, by_flights, [](In i, Table t) { bench::BenchFisheye(i.seeds, i.jobs(), t); }},
      {"landings", kGeneral, by_flights, [](In i, Table t) { bench::BenchLandings(i.seeds, i.jobs(), t); }},
      {"attitude", kGeneral, by_flights, [](In i, Table t) { bench::BenchAttitude(i.seeds, i.jobs(), t); }},
      {"horizon", kGeneral, by_all,
       [](In i, Table t) { bench::BenchHorizon(i.seeds.first, i.jobs(), i.folder, t); }},
      {"gyro_failure", kGeneral, by_flights,
       [](In i, Table t) { bench::BenchGyroFailure(i.seeds, i.jobs(), t); }},
      {"drift", kGeneral, by_flights, [](In i, Table t) { bench::BenchDrift(i.seeds, i.jobs(), t); }},
      {"heights", kGeneral, by_seeds, [](In i, Table t) { bench::BenchHeights(i.seeds, t); }},
      {"speed", kGeneral, by_seeds, [](In i, Table t) { bench::BenchSpeed(i.seeds, t); }},
      {"render",
       kGeneral,
       {"--seeds", "--backend"},
       [](In i, Table t) { bench::BenchRender(i.seeds.first, i.seeds.last, i.arguments.backend, t); }},
      {"calibration", kGeneral, by_flights,
       [](In i, Table t) { bench::BenchCalibration(i.seeds.first, i.seeds.last, i.jobs(), t); }},
      {"servo", kGeneral, {}, [](In, Table t) { bench::BenchServo(t); }},
      {"servo_flights", kGeneral, by_flights,
       [](In i, Table t) { bench::BenchServoFlights(i.seeds, i.jobs(), t); }},
      {"direct", kGeneral, by_flights, [](In i, Table t) { bench::BenchDirect(i.seeds, i.jobs(), t); }},
      {"trackers", kGeneral, by_seeds,
       [](In i, Table t) {
         bench::BenchTrackers(i.seeds.first, i.seeds.last, t);
         bench::BenchPadTrackers(i.seeds, t);
       }},
      {"alignment", kGeneral, by_seeds, [](In i, Table t) { bench::BenchAlignment(i.seeds, t); }},
      {"follow", kGeneral, by_flights, [](In i, Table t) { bench::BenchFollow(i.seeds, i.jobs(), t); }},
      {"follow_thesis", kGeneral, by_flights,
       [](In i, Table t) { bench::BenchFollowSteps(i.seeds, i.jobs(), t); }},
      {"avoid_thesis", kGeneral, by_flights,
       [](In i, Table t) { bench::BenchAvoidSight(i.seeds, i.jobs(), t); }},
      {"avoid", kGeneral, by_flights, [](In i, Table t) { bench::BenchAvoid(i.seeds, i.jobs(), t); }},
      {"contrast", kGeneral, by_all,
       [](In i, Table t) { bench::BenchContrast(i.seeds.first, i.seeds.last, i.jobs(), i.folder, t); }},
      {"planar", kGeneral, by_all,
       [](In i, Table t) { bench::BenchPlanar(i.seeds, i.jobs(), i.folder, bench::PlanarTrackers, t); }},
      {"stabilise", kGeneral, by_files, [](In i, Table t) { bench::BenchStabilise(i.seeds, i.folder, t); }},
      {"mosaic", kGeneral, by_files, [](In i, Table t) { bench::BenchMosaic(i.seeds, i.folder, t); }},
      {"stream", kGeneral, {}, [](In, Table t) { bench::BenchStream(t); }},
      {"features", kGeneral, by_seeds,
       [](In i, Table t) { bench::BenchFeatures(i.seeds.first, i.seeds.last, t); }},
      {"homographies", kGeneral, by_seeds, [](In i, Table t) { bench::BenchHomographies(i.seeds.first, t); }},
      {"plane_pose", kGeneral, by_seeds, [](In i, Table t) { bench::BenchPlanePose(i.seeds.first, t); }},
      {"wire", kByName, by_all, [](In i, Table t) { bench::BenchWire(i.seeds, i.jobs(), i.folder, t); }},
      {"link_faults", kByName, by_all,
       [](In i, Table t) { bench::BenchLinkFaults(i.seeds, i.jobs(), i.folder, t); }},
      {"campaign", kByName, by_seeds,
       [](In i, Table t) {
         bench::BenchCampaign(static_cast<int>(i.seeds.last - i.seeds.first) + 1, i.folder, t);
       }},
      {"horizon_training",
       kByName,
       {"--fov-deg", "--seeds", "--jobs"},
       [](In i, Table t) {
         bench::TrainBorderBelief(i.photographs, i.arguments.fov_deg, i.seeds.first, i.jobs(), t);
       }},
      {"horizon_pictures",
       kByName,
       {"--fov-deg", "--out"},
       [](In i, Table t) { bench::BenchPhotographs(i.photographs, i.arguments.fov_deg, i.folder, t); }},
      {"lockstep", kByName, {}, [](In, Table t) { bench::BenchLockstep(t); }},
      {"live", kByName, by_files, [](In i, Table t) { bench::BenchLive(i.seeds, i.folder, t); }},
      {"frames",
       kByName,
       {"--seeds", "--jobs", "--backend", "--out"},
       [](In i, Table t) {
         bench::BenchFrames(i.seeds.first, i.seeds.last, i.jobs(), i.arguments.backend, i.folder, t);
       }},
      {"hashes", kByName, by_flights,
       [](In i, Table t) { bench::BenchHashes(i.seeds, i.jobs(), Root() / "results" / "hashes.csv", t); }},
      {"throughput", kOfOwnTables, {}, [](In i, Table t) { bench::BenchThroughput(i.folder, t); }},
      {"limits", kOfOwnTables, {}, [](In, Table t) { bench::BenchLimits(t); }},
      // Is no table of figures; see BenchCommand.
      {"timings", kOfOwnTables, {"--against", "--rounds", "--clock", "--in-turn"}, nullptr},
  };
}

}  // namespace

int BenchInput::jobs() const { return arguments.jobs; }

bool Bench::Takes(const std::string& option) const {
  return std::find(options.begin(), options.end(), option) != options.end();
}

const std::vector<Bench>& Benches() {
  static const std::vector<Bench> kBenches = MakeBenches();
  return kBenches;
}

}  // namespace kestrel::app
