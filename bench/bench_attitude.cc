// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_attitude.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/statistics.h"
#include "geometry/tait_bryan.h"

namespace kestrel::bench {

std::vector<std::string> ThesisRig() {
  return {"vehicle=sr20",
          "mount.position_m=[0.7, 0, -0.2]",
          "flight.manoeuvres.tilt_deg=8",
          "landscape.snow_share=0",
          "flight.baseline=true",
          "criteria={}"};
}

void BenchAttitude(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  struct Reference {
    const char *roll, *pitch, *yaw;
  };
  constexpr Reference kThesis[] = {
      {"0.18", "4.37", "1.25"}, {"2.75", "2.83", "10.8"}, {"0.94", "4.09", "6.04"}, {"2.86", "1.92", "5.01"}};
  double outliers = 0;
  std::vector<double> within, vision_ms;
  for (int k = 0; k < 4; ++k) {
    const std::string name = fmt::format("attitude_{}", k + 1);
    const auto flights = flight::FlyAll(name, {}, seeds, jobs, name);
    const auto thesis_flights =
        flight::FlyAll(name, ThesisRig(), seeds, jobs, name + ", the thesis's method");
    const auto add = [&](const char* what, const char* metric, double target, const char* thesis) {
      const std::string line = fmt::format("{}, {}", name, what);
      table.push_back({line, Rms(flight::Values(flights, metric)), "deg", target, false, thesis});
      table.push_back({line + ", the thesis's method on its rig",
                       Rms(flight::Values(thesis_flights, std::string("baseline_") + metric)), "deg",
                       2 * std::stod(thesis), false, thesis});
    };
    add("roll RMSE", "roll_rmse_deg", 0.4, kThesis[k].roll);
    add("pitch RMSE", "pitch_rmse_deg", 0.4, kThesis[k].pitch);
    add("yaw RMSE", "yaw_rmse_deg", 1, kThesis[k].yaw);
    table.push_back({name + ", yaw RMSE in the second half over the first",
                     Rms(flight::Values(flights, "yaw_rmse_second_half_deg")) /
                         Rms(flight::Values(flights, "yaw_rmse_first_half_deg")),
                     "times",
                     {},
                     false,
                     ""});
    const std::vector<double> share = flight::Values(flights, "attitude_share");
    table.push_back({name + ", frames with an attitude",
                     *std::min_element(share.begin(), share.end()),
                     "share",
                     {},
                     true,
                     ""});
    for (const double n : flight::Values(flights, "attitude_outliers")) outliers += n;
    for (const double w : flight::Values(flights, "attitude_within_2_sigma")) within.push_back(w);
    for (const flight::FlownScenario& f : flights) vision_ms.push_back(f.summary.stages.at("vision").mean_ms);
  }
  table.push_back({"attitude, errors over 5 degrees in fixes", outliers, "frames", 0, false, "seen"});
  double mean_within = 0;
  for (const double w : within) mean_within += w / static_cast<double>(within.size());
  table.push_back({"attitude, within 2 sigma", mean_within, "share", 0.9, true, "none"});
  table.push_back({"attitude and heading, mean a frame", Quantile(vision_ms, 0.5), "ms", 5, false, "50"});
}

namespace {

// Between a flight with a failure and the same one without: of the true "down" in B, while the failure lasts.
double TiltApart(const flight::FlownScenario& failed, const flight::FlownScenario& sound) {
  std::vector<double> apart;
  for (std::size_t i = 0; i < std::min(failed.rows.size(), sound.rows.size()); ++i) {
    if (!failed.rows[i].now.attitude_failed) continue;
    const auto down = [&](const flight::FlownScenario& f) {
      return Eigen::Vector3d(f.rows[i].now.X_NB.R.conjugate() * Eigen::Vector3d::UnitZ());
    };
    apart.push_back(Degrees(std::asin(std::min(1.0, down(failed).cross(down(sound)).norm()))));
  }
  return Rms(apart);
}

}  // namespace

void BenchGyroFailure(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  const auto sound = flight::FlyAll("gyro_failure", {"sensors.attitude_faults=[]", "criteria={}"}, seeds,
                                    jobs, "gyro_failure, without a failure");
  for (const std::string type : {"drift", "freeze", "silent"}) {
    const std::string name = "gyro_failure, " + type;
    const auto flights =
        flight::FlyAll("gyro_failure", {"sensors.attitude_faults.0.type=" + type}, seeds, jobs, name);
    std::vector<double> apart;
    for (std::size_t i = 0; i < flights.size(); ++i) apart.push_back(TiltApart(flights[i], sound[i]));
    const auto add = [&](const char* what, double value, const char* unit, std::optional<double> most) {
      table.push_back({fmt::format("{}: {}", name, what), value, unit, most, false, ""});
    };
    const auto worst = [&](const char* metric) { return Largest(flight::Values(flights, metric)); };
    add("level, off the same flight without it, RMS", Largest(apart), "deg", 3);
    add("attitude flown by, off the truth, RMS", worst("failure_attitude_rms_deg"), "deg", 3);
    add("tilt, lean against the wind and all, RMS", worst("failure_tilt_rms_deg"), "deg", {});
    add("heading", worst("failure_heading_worst_deg"), "deg", 3);
    add("height", worst("failure_height_worst_m"), "m", 1);
    add("place", worst("failure_place_worst_m"), "m", {});
    add("noticed after", worst("failure_noticed_s"), "s", {});
    const auto back = flight::Values(flights, "failure_returned");
    table.push_back({name + ": by its own attitude again", *std::min_element(back.begin(), back.end()),
                     "share", 1, true, ""});
  }
}

}  // namespace kestrel::bench
