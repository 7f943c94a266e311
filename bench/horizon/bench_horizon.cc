// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/bench_horizon.h"

#include <fmt/format.h>

#include <cmath>

#include "base/file/files.h"
#include "base/process/in_parallel.h"
#include "base/stopwatch.h"
#include "bench/horizon/bench_horizon_pictures.h"
#include "bench/horizon/horizon_judgement.h"
#include "flight/simulated/scenario.h"

namespace kestrel::bench {
namespace {

constexpr int kLandscapesEach = 25, kStillsEach = 52;
constexpr int kLandscapesEachOther = 5;  // through the other lenses
constexpr std::size_t kWorst = 12;       // stills that are shown

// What all stills share.
struct StillCamera {
  flight::LoadedScenario loaded;
  Pose X_BC;
  cv::Mat forbidden;
  vision::Skyline skyline;
  sim::ImageSensor sensor;

  StillCamera(flight::LoadedScenario scenario, std::uint64_t seed)
      : loaded(std::move(scenario)),
        X_BC(vision::MountPose(loaded.simulator.mount)),
        forbidden(sim::OwnParts(sim::MakeModel(loaded.simulator.scene, false).get(), loaded.simulator.camera,
                                X_BC)),
        skyline(loaded.simulator.camera, X_BC.R.toRotationMatrix(), forbidden, {}),
        sensor(loaded.simulator.image, loaded.simulator.camera, seed) {}

  // The disc of the sun, and no part of the aircraft before it.
  bool SeesSun(const sim::LandscapeParameters& p, const Pose& X_NB) const {
    const double a = Radians(p.sun_azimuth_deg), e = Radians(p.sun_elevation_deg);
    const Eigen::Vector3d sun_N(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), -std::sin(e));
    const auto uv =
        vision::Project(loaded.simulator.camera, Eigen::Vector3d((X_NB.R * X_BC.R).conjugate() * sun_N));
    if (!uv) return false;
    const cv::Point at(static_cast<int>(std::lround(uv->x())), static_cast<int>(std::lround(uv->y())));
    return cv::Rect(0, 0, forbidden.cols, forbidden.rows).contains(at) && !forbidden.at<uchar>(at);
  }

  vision::SkylineExpected Expectation(const Still& still, const Pose& X_NB) const {
    const Eigen::Vector3d down_C = (X_NB.R * X_BC.R).conjugate() * Eigen::Vector3d::UnitZ();
    return {ExpectedDown(down_C, still), std::sqrt(2) * kExpectedDownSigma, still.expected_height_m};
  }
};

double RidgeFrom(const sim::RidgeParameters& ridge, const Eigen::Vector3d& p_N) {
  if (ridge.height_deg <= 0) return 0;
  const double a = Radians(ridge.azimuth_deg);
  const Eigen::Vector3d crest(ridge.distance_m * std::cos(a), ridge.distance_m * std::sin(a),
                              -ridge.distance_m * std::tan(Radians(ridge.height_deg)));
  const Eigen::Vector3d to = crest - p_N;
  return std::max(0.0, Degrees(std::atan2(-to.z(), to.head<2>().norm())));
}

JudgedStill Measure(const StillCamera& camera, StillRenderer& renderer, const StillSweep& sweep,
                    std::size_t index, std::uint64_t seed) {
  const Still& still = sweep.stills[index];
  const StillLandscape& landscape = sweep.landscapes[static_cast<std::size_t>(still.landscape)];
  JudgedStill judged{still, landscape, renderer.PoseOf(still, seed), 0, 0, "", {}};
  const cv::Mat image = camera.sensor.Expose(renderer.Draw(judged.X_NB), static_cast<std::int64_t>(index));
  for (const Way way : {kAlone, kExpecting}) {
    const double start_ms = ThreadCpu_ms();
    const vision::SkylineResult result = camera.skyline.Measure(
        image, way == kAlone ? vision::SkylineExpected{} : camera.Expectation(still, judged.X_NB));
    const double cpu_ms = ThreadCpu_ms() - start_ms;
    judged.answers[way] = Judge(result, camera.X_BC.R.toRotationMatrix(), judged.X_NB);
    judged.answers[way].cpu_ms = cpu_ms;
  }
  judged.tilt_deg = Degrees(std::acos(std::cos(still.attitude.roll) * std::cos(still.attitude.pitch)));
  judged.ridge_deg = RidgeFrom(landscape.parameters.ridge, judged.X_NB.p);
  judged.sun = landscape.parameters.cloud_cover >= 1               ? "overcast"
               : camera.SeesSun(landscape.parameters, judged.X_NB) ? "in view"
                                                                   : "outside";
  return judged;
}

// Landscape by landscape, several at a time; in the order of the sweep, whatever the order of their ends.
std::vector<JudgedStill> MeasureAll(const StillCamera& camera, const StillSweep& sweep, std::uint64_t seed,
                                    int jobs) {
  std::vector<JudgedStill> judged(sweep.stills.size());
  InParallel(sweep.landscapes.size(), jobs, "horizon", "landscapes", [&](std::size_t l) {
    StillRenderer renderer(sweep.landscapes[l], camera.loaded.simulator.scene, camera.loaded.simulator.camera,
                           camera.X_BC);
    for (std::size_t i = l * kStillsEach; i < (l + 1) * kStillsEach; ++i)
      judged[i] = Measure(camera, renderer, sweep, i, seed);
  });
  return judged;
}

void WriteStills(const std::filesystem::path& file, const std::vector<JudgedStill>& all) {
  std::string text =
      "still,landscape,world,landscape_seed,haze_m,light,sun_azimuth_deg,sun_elevation_deg,sun,ridge_height_"
      "deg,"
      "ridge_width_deg,ridge_distance_m,ridge_azimuth_deg,ridge_from_there_deg,north_m,east_m,height_m,"
      "heading_deg,pitch_deg,roll_deg,tilt_deg,expected_error_deg,expected_height_m";
  for (const char* way : kWays)
    text += fmt::format(
        ",{0}_said,{0}_roll_error_deg,{0}_pitch_error_deg,{0}_roll_sigma_deg,{0}_pitch_sigma_deg,{0}_error_"
        "deg,"
        "{0}_circle_seen,{0}_agreement,{0}_contrast,{0}_rival,{0}_dip_deg",
        way);
  text += '\n';
  for (std::size_t i = 0; i < all.size(); ++i) {
    const JudgedStill& s = all[i];
    const sim::LandscapeParameters& p = s.landscape.parameters;
    text += fmt::format("{},{},{},{},{:.0f},{:.3f},{:.2f},{:.2f},{}", i, s.still.landscape, s.landscape.world,
                        p.seed, p.haze_m, p.light, p.sun_azimuth_deg, p.sun_elevation_deg, s.sun);
    text += fmt::format(",{:.3f},{:.1f},{:.0f},{:.2f},{:.3f},{:.2f},{:.2f},{:.3f}", p.ridge.height_deg,
                        p.ridge.width_deg, p.ridge.distance_m, p.ridge.azimuth_deg, s.ridge_deg, s.X_NB.p.x(),
                        s.X_NB.p.y(), s.still.height_m);
    text += fmt::format(",{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.2f}", Degrees(s.still.attitude.yaw),
                        Degrees(s.still.attitude.pitch), Degrees(s.still.attitude.roll), s.tilt_deg,
                        Degrees(s.still.expected.norm()), s.still.expected_height_m);
    for (const Answer& a : s.answers) {
      if (a.fix())
        text +=
            fmt::format(",{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.3f},{:.3f},{:.2f},{:.3f},{:.3f}", a.result,
                        a.roll_error_deg, a.pitch_error_deg, a.roll_sigma_deg, a.pitch_sigma_deg, a.error_deg,
                        a.circle_seen, a.agreement, a.contrast, a.rival, a.dip_deg);
      else
        text += fmt::format(",{},,,,,,,,,,", a.result);
    }
    text += '\n';
  }
  WriteFile(file, text);
}

// A row for each range of each factor: all numbers, which the table of figures has not the room for.
struct FactorRow {
  std::string factor, range;
  Way way;
  Statistics statistics;
};

std::vector<FactorRow> RowsOf(const std::vector<JudgedStill>& all) {
  std::vector<FactorRow> rows;
  for (const Way way : {kAlone, kExpecting}) {
    rows.push_back({"all", "", way, StatisticsOf(all, way, [](const JudgedStill&) { return true; })});
    for (const Factor& factor : Factors())
      for (int r = 0; r < static_cast<int>(factor.ranges.size()); ++r)
        rows.push_back({factor.name, factor.ranges[static_cast<std::size_t>(r)], way,
                        StatisticsOf(all, way, [&](const JudgedStill& s) { return factor.of(s) == r; })});
  }
  return rows;
}

std::vector<std::string> Reasons(const std::vector<FactorRow>& rows) {
  std::vector<std::string> names;
  for (const FactorRow& row : rows)
    for (const auto& [name, count] : row.statistics.refused)
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

void WriteFactors(const std::filesystem::path& file, const std::vector<FactorRow>& rows) {
  const std::vector<std::string> reasons = Reasons(rows);
  std::string text =
      "way,factor,range,stills,with_attitude,outliers,roll_rmse_deg,pitch_rmse_deg,roll_bias_deg,pitch_bias_"
      "deg,"
      "error_median_deg,error_p95_deg,within_2_sigma";
  for (const std::string& reason : reasons) text += "," + reason;
  text += '\n';
  for (const auto& [factor, range, way, s] : rows) {
    text += fmt::format("{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}", kWays[way],
                        factor, range, s.stills, s.fixes, s.outliers, s.roll_rmse_deg, s.pitch_rmse_deg,
                        s.roll_bias_deg, s.pitch_bias_deg, s.median_deg, s.p95_deg, s.within_2_sigma);
    for (const std::string& reason : reasons)
      text += fmt::format(",{}", s.refused.contains(reason) ? s.refused.at(reason) : 0);
    text += '\n';
  }
  WriteFile(file, text);
}

void PrintFactors(const std::vector<FactorRow>& rows) {
  for (const Way way : {kAlone, kExpecting}) {
    fmt::print("{}\n{:<7} {:<15} {:>6} {:>7} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8}  {}\n",
               way == kAlone ? "Each image alone"
                             : "With \"down\" expected to 1.5 degrees a side and the height to 2 m",
               "", "", "stills", "with", "RMSE roll", "pitch deg", "95 % deg", "over 5", "in 2 dev",
               "refused %", "");
    std::string last;
    for (const auto& [factor, range, row_way, s] : rows) {
      if (row_way != way) continue;
      std::string refused;
      for (const auto& [name, count] : s.refused)
        if (100 * count >= s.stills)
          refused += fmt::format("{}{} {:.0f}", refused.empty() ? "" : ", ", name, 100.0 * count / s.stills);
      fmt::print("{:<7} {:<15} {:>6} {:>5.1f} % {:>9.3f} {:>9.3f} {:>8.2f} {:>8} {:>8.3f} {:>8.1f}  {}\n",
                 factor == last ? "" : factor, range, s.stills, 100 * s.Share(), s.roll_rmse_deg,
                 s.pitch_rmse_deg, s.p95_deg, s.outliers, s.within_2_sigma, 100 * (1 - s.Share()), refused);
      last = factor;
    }
    fmt::print("\n");
  }
}

void AddFigures(const std::vector<JudgedStill>& all, const std::vector<FactorRow>& rows,
                std::vector<records::Figure>& table) {
  for (const auto& [factor, range, way, s] : rows) {
    if (s.stills == 0) continue;
    const std::string name = std::string("stills, ") + (way == kAlone ? "alone" : "expecting") +
                             (range.empty() ? "" : ", " + factor + " " + range);
    const auto add = [&](const char* what, double value, const char* unit, std::optional<double> target = {},
                         bool at_least = false) {
      table.push_back({name + ", " + what, value, unit, target, at_least, ""});
    };
    if (factor == "all") {
      add("roll RMSE", s.roll_rmse_deg, "deg");
      add("pitch RMSE", s.pitch_rmse_deg, "deg");
      add("roll bias", s.roll_bias_deg, "deg");
      add("pitch bias", s.pitch_bias_deg, "deg");
      add("error, 95th percentile", s.p95_deg, "deg");
      add("errors over 5 degrees in fixes", s.outliers, "stills", 0);
      add("within 2 sigma", s.within_2_sigma, "share", 0.90, true);
      add("within 2 sigma, no more", s.within_2_sigma, "share", 0.99);
      add("with an attitude", s.Share(), "share");
      for (const auto& [reason, count] : s.refused)
        add(("refused: " + reason).c_str(), static_cast<double>(count) / s.stills, "share");
      double ms = 0;
      for (const JudgedStill& still : all) ms += still.answers[way].cpu_ms / static_cast<double>(all.size());
      add("mean of one core", ms, "ms", 5);
    } else if (factor == "ridge" && range != "none") {
      add("error, 95th percentile", s.p95_deg, "deg", 1.5);
    } else {
      add("error, 95th percentile", s.p95_deg, "deg");
    }
  }
}

void AddOtherLens(const std::string& name, const Statistics& s, std::vector<records::Figure>& table) {
  table.push_back({name + ": roll RMSE", s.roll_rmse_deg, "deg", {}, false, ""});
  table.push_back({name + ": pitch RMSE", s.pitch_rmse_deg, "deg", {}, false, ""});
  table.push_back({name + ": error, 95th percentile", s.p95_deg, "deg", {}, false, ""});
  table.push_back(
      {name + ": errors over 5 degrees in fixes", static_cast<double>(s.outliers), "stills", 0, false, ""});
  table.push_back({name + ": within 2 sigma", s.within_2_sigma, "share", 0.90, true, ""});
  table.push_back({name + ": with an attitude", s.Share(), "share", {}, false, ""});
}

}  // namespace

void BenchHorizon(std::uint64_t seed, int jobs, const std::filesystem::path& folder,
                  std::vector<records::Figure>& table) {
  std::filesystem::create_directories(folder);
  const std::vector<std::string> worlds_there = Factors().front().ranges;
  std::vector<StillLandscape> worlds;
  for (const std::string& world : worlds_there) {
    // With a landscape of its own seed, a scenario has the world's whole landscape.
    const flight::LoadedScenario loaded =
        flight::LoadScenario("attitude_1", {"world=" + world, "landscape.seed=1"});
    worlds.push_back({world, loaded.scenario.landscape.value()});
  }
  const StillCamera camera(flight::LoadScenario("attitude_1"), seed);
  const StillSweep sweep = DrawSweep(worlds, kLandscapesEach, kStillsEach, seed);
  const std::vector<JudgedStill> all = MeasureAll(camera, sweep, seed, jobs);
  const std::vector<FactorRow> rows = RowsOf(all);
  WriteStills(folder / "stills.csv", all);
  WriteFactors(folder / "factors.csv", rows);
  PrintFactors(rows);
  fmt::print("Rows, ranges and pictures: {}\n\n", folder.string());
  DrawHorizonBench(folder, all);

  // The worst that was said to be valid, drawn again.
  std::vector<std::pair<double, std::pair<std::size_t, Way>>> worst;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const Way way : {kAlone, kExpecting})
      if (all[i].answers[way].fix()) worst.push_back({all[i].answers[way].error_deg, {i, way}});
  std::sort(worst.begin(), worst.end(), std::greater<>());
  worst.resize(std::min(worst.size(), kWorst));
  std::vector<cv::Mat> seen;
  for (const auto& [error_deg, which] : worst) {
    const auto& [i, way] = which;
    StillRenderer renderer(all[i].landscape, camera.loaded.simulator.scene, camera.loaded.simulator.camera,
                           camera.X_BC);
    const cv::Mat image = camera.sensor.Expose(renderer.Draw(all[i].X_NB), static_cast<std::int64_t>(i));
    const vision::SkylineExpected expected =
        way == kAlone ? vision::SkylineExpected{} : camera.Expectation(all[i].still, all[i].X_NB);
    seen.push_back(DrawStill(image, camera.loaded.simulator.camera, camera.X_BC, all[i], i, way,
                             camera.skyline.Measure(image, expected)));
  }
  WriteSheet(folder / "worst.jpg", seen);

  AddFigures(all, rows, table);
  for (const char* lens : {"fisheye", "thesis_2_8mm"}) {
    const StillCamera other(
        flight::LoadScenario("attitude_1", {"mount.pitch_deg=90", fmt::format("camera={}", lens)}), seed);
    const auto stills =
        MeasureAll(other, DrawSweep(worlds, kLandscapesEachOther, kStillsEach, seed + 1), seed, jobs);
    for (const Way way : {kAlone, kExpecting})
      AddOtherLens(fmt::format("stills, {} forward, {}", lens, kWays[way]),
                   StatisticsOf(stills, way, [](const JudgedStill&) { return true; }), table);
  }
}

}  // namespace kestrel::bench
