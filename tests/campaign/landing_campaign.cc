// SPDX-License-Identifier: Apache-2.0
#include "tests/campaign/landing_campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <random>

#include "records/video/video.h"

namespace kestrel::campaign {
namespace {

constexpr const char* kPlan = R"(name: landing_dispersion
scenario: landing
runs: 1000
seed: 7
sampling: latin_hypercube
vary:
  wind.mean_m_s: {uniform: [0, 6]}
  wind.from_deg: {uniform: [0, 360]}
  image.latency_s: {uniform: [0.02, 0.12]}
  image.noise_grey: {log_uniform: [0.5, 40]}
  start.height_m: {uniform: [3.5, 5.5]}
  start.scatter_m: {uniform: [0, 1.5]}
  world: {choice: [autumn_clear, winter_cloudy, summer_sun]}
metrics: [touchdown_error_m, touchdown_sink_m_s, touchdown_tilt_deg, rest_error_m]
thresholds:
  success: {min: 0.98}
  touchdown_error_m: {quantile: 0.95, max: 0.15}
)";
constexpr const char* kScenario = R"(mission: landing
duration_s: 60
criteria:
  touchdown_error_m: {max: 0.12}
  touchdown_sink_m_s: {max: 0.4}
  touchdown_tilt_deg: {max: 8}
  rest_error_m: {max: 0.15}
)";

// The same on every machine, unlike the distributions of <random>.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : bits_(seed) {}
  double Uniform(double low = 0, double high = 1) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  double Normal() { return std::sqrt(-2 * std::log(1 - Uniform())) * std::cos(2 * M_PI * Uniform()); }

 private:
  std::mt19937_64 bits_;
};

void WriteRecords(const std::filesystem::path& folder, const RunResult& run, double height_m, double away_m,
                  double from, bool video) {
  std::filesystem::create_directories(folder);
  std::ofstream file(folder / "telemetry.csv");
  file << "sequence,t_s,phase,truth_x_m,truth_y_m,truth_z_m,outcome\n";
  const bool lands = run.metrics.contains("touchdown_s");
  const double end_s = lands ? run.metrics.at("touchdown_s") : 60;
  const double north = lands ? run.metrics.at("touchdown_north_m") : away_m * 3,
               east = lands ? run.metrics.at("touchdown_east_m") : -away_m * 2;
  for (int k = 0; k * 0.05 <= end_s; ++k) {
    const double t = k * 0.05, left = std::exp(-t / 5),
                 down = lands ? std::min(1.0, t / end_s) : std::min(0.5, t / 40);
    file << fmt::format("{},{},descend,{},{},{},\n", k, t,
                        north + (away_m * std::cos(from) - north) * left + 0.04 * std::sin(1.1 * t),
                        east + (away_m * std::sin(from) - east) * left + 0.04 * std::sin(0.7 * t + 1),
                        -(height_m * (1 - down) + 0.16));
  }
  if (!video) return;
  records::Video film(folder / "video.mp4", 20);
  for (int k = 0; k < 10; ++k) {
    cv::Mat image(240, 320, CV_8UC3, cv::Scalar(90, 110, 100));
    cv::circle(image, {160, 120}, 20 + 6 * k, {240, 240, 240}, 5);
    film.Write(image);
  }
  film.Close();
}

}  // namespace

ReportSubject LandingCampaign(std::int64_t runs, const std::filesystem::path& folder) {
  const std::array worlds = {"autumn_clear", "winter_cloudy", "summer_sun"};
  ReportSubject subject;
  subject.identity = {"landing_dispersion", kScenario, kPlan, "0.1.0 13664f7", {}};
  SampleTable& table = subject.identity.table;
  table.keys = {"seed",
                "image.latency_s",
                "image.noise_grey",
                "start.height_m",
                "start.scatter_m",
                "wind.from_deg",
                "wind.mean_m_s",
                "world"};
  Dice dice(20);
  int passes_recorded = 0;
  bool filmed = false;
  for (std::int64_t row = 0; row < runs; ++row) {
    const double latency_s = dice.Uniform(0.02, 0.12), noise = 0.5 * std::pow(80, dice.Uniform()),
                 height_m = dice.Uniform(3.5, 5.5), away_m = dice.Uniform(0, 1.5),
                 from = dice.Uniform(0, 2 * M_PI), wind = dice.Uniform(0, 6);
    const auto world = static_cast<std::size_t>(dice.Uniform(0, 3));
    table.rows.push_back({fmt::format("{}", 1000 + row), fmt::format("{}", latency_s),
                          fmt::format("{}", noise), fmt::format("{}", height_m), fmt::format("{}", away_m),
                          fmt::format("{}", from * 180 / M_PI), fmt::format("{}", wind), worlds[world]});
    RunResult run;
    run.row = row;
    const double spread_m = 0.008 + 0.16 * latency_s + 0.0016 * wind * wind * (0.4 + 8 * latency_s) * 0.5;
    const double north = -0.004 * wind * std::cos(from) + spread_m * dice.Normal();
    const double east = -0.004 * wind * std::sin(from) + spread_m * dice.Normal();
    auto& m = run.metrics;
    m = {{"touchdown_north_m", north},
         {"touchdown_east_m", east},
         {"touchdown_error_m", std::hypot(north, east)},
         {"touchdown_sink_m_s", 0.2 + 0.006 * wind * std::abs(dice.Normal()) + 0.01 * dice.Normal()},
         {"touchdown_speed_m_s", std::abs(0.02 * dice.Normal()) + 0.004 * wind},
         {"touchdown_tilt_deg", std::hypot(0.5 * dice.Normal() + 0.45 * wind, 0.5 * dice.Normal())},
         {"touchdown_s", 12 + 3.4 * height_m + 2 * away_m + 0.3 * noise + 1.5 * std::abs(dice.Normal())},
         {"max_tilt_deg", 4 + 1.2 * wind + 2 * away_m + std::abs(dice.Normal())},
         {"fix_share", std::max(0.3, 0.995 - 0.0005 * noise - 0.0002 * noise * noise * (world == 2) +
                                         0.002 * dice.Normal())},
         {"longest_loss_s", 0.1 + 0.02 * noise * dice.Uniform()}};
    m["rest_error_m"] = m["touchdown_error_m"] + 0.01 * std::abs(dice.Normal());
    m["rest_tilt_deg"] = 0.05 * std::abs(dice.Normal());
    const bool met =
        m["touchdown_error_m"] <= 0.12 && m["touchdown_tilt_deg"] <= 8 && m["rest_error_m"] <= 0.15;
    run.status = met ? RunStatus::kPassed : RunStatus::kFailed;
    run.outcome = "landed";
    run.state_hash = fmt::format("{:016x}", 0x9e3779b97f4a7c15u * static_cast<std::uint64_t>(row + 1));
    run.image_hash = fmt::format("{:016x}", 0xc2b2ae3d27d4eb4fu * static_cast<std::uint64_t>(row + 1));
    run.execution = {static_cast<int>(row % 2), 2.4 + 0.3 * dice.Uniform(), 0.006, 212, "", ""};
    if (noise > 30 && world == 2 && dice.Uniform() < 0.25) {  // the pad is lost in the noise
      run.status = RunStatus::kFailed, run.outcome = "completed";
      m = {{"max_tilt_deg", 11.5}, {"fix_share", 0.34}, {"longest_loss_s", 21}};
    } else if (row % 613 == 412) {
      run.status = RunStatus::kCrashed, run.outcome = "signal 11: segmentation fault", m.clear();
      run.state_hash = run.image_hash = "";
      run.execution.log =
          "kestrel: row 412\n  </script><script>alert('escape me')</script> <!-- 4 < 5 & \"quoted\"\n";
    } else if (row % 811 == 222) {
      run.status = RunStatus::kTimedOut, run.outcome = "no end within 600 s", m.clear();
      run.state_hash = run.image_hash = "";
    }
    const bool passed = run.status == RunStatus::kPassed;
    const bool flown = !m.empty();
    if (flown && (!passed || passes_recorded < 6)) {
      const auto records = folder / "recordings" / fmt::format("{}", row);
      WriteRecords(records, run, height_m, away_m, from, !passed && !filmed);
      passes_recorded += passed;
      filmed = filmed || !passed;
      run.execution.recording = records.string();
    }
    subject.results.push_back(run);
  }
  subject.summary =
      Summarise(subject.identity, subject.results,
                std::map<std::string, Threshold>{{"success", {std::nullopt, std::nullopt, 0.98}},
                                                 {"touchdown_error_m", {0.95, 0.15, std::nullopt}}});
  subject.results_file = (folder / "results.sqlite").string();
  subject.replay = "./kestrel campaign replay landing_dispersion";
  subject.again = "./kestrel campaign landing_dispersion";
  return subject;
}

TuningHistory HoverTuning() {
  TuningHistory tuning{"20 hold_horizontal_rmse_m + settle_s / 10", 6.8, "", {}, {}};
  Dice dice(5);
  const std::pair<const char*, double> methods[] = {
      {"CMA-ES", 70}, {"cross-entropy", 120}, {"random search", 260}};
  for (const auto& [method, slowness] : methods) {
    for (int repetition = 1; repetition <= 5; ++repetition) {
      SearchCurve curve{method, repetition, {}, {}, slowness / 100 + 0.01 * repetition};
      double best = 1e9;
      for (int flights = 20; flights <= 500; flights += 20) {
        const double cost = 1.9 + 0.25 * std::abs(dice.Normal()) +
                            5.5 * std::exp(-flights / slowness) * dice.Uniform(0.6, 1.4);
        best = std::min(best, cost);
        curve.flights.push_back(flights), curve.cost.push_back(best);
      }
      tuning.searches.push_back(curve);
    }
  }
  tuning.gains = {{"pilot.servo.lambda_per_s", 0.2, 0.83, 0.05, 3, true},
                  {"pilot.servo.damping", 1, 0.42, 0, 2, false}};
  return tuning;
}

}  // namespace kestrel::campaign
