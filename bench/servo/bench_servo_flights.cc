// SPDX-License-Identifier: Apache-2.0
#include "bench/servo/bench_servo_flights.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "base/statistics.h"
#include "mission/servo/servo_laws.h"

namespace kestrel::bench {
namespace {

struct Task {
  std::string name;
  std::vector<std::string> start;
  bool half_turn = false;
};

// By the aircraft's freedoms: it cannot be turned about a line in the target's plane, so the target is.
std::vector<Task> Tasks() {
  std::vector<Task> tasks;
  for (const int turn_deg : {30, 90, 150, 180})
    tasks.push_back({fmt::format("about the axis, {} deg", turn_deg),
                     {"start.height_m=3", fmt::format("start.yaw_deg={}", turn_deg)},
                     turn_deg == 180});
  tasks.push_back({"along the axis, 1.6 to 3 m", {"start.height_m=1.6"}});
  tasks.push_back({"along the axis, 6 to 3 m", {"start.height_m=6"}});
  tasks.push_back({"aside, 0.7 m", {"start.height_m=3", "start.offset_m=[0.4,-0.57]"}});
  tasks.push_back({"target's plane tilted, 20 deg",
                   {"start.height_m=4", "pad.tilt_deg=20", "pad.height_m=0.3", "flight.pad_tilt_deg=20"}});
  tasks.push_back({"general, 110 deg about the axis",
                   {"start.height_m=5", "start.offset_m=[0.5,-0.4]", "start.yaw_deg=110"}});
  return tasks;
}

// What theory says of half a turn: Chaumette 1998; Corke and Hutchinson 2001.
bool Stable(const std::string& law) { return !law.starts_with("points_") && law != "bearings"; }

std::vector<std::string> With(std::vector<std::string> overrides, const std::string& law) {
  overrides.push_back("flight.law=" + law);
  overrides.push_back("criteria={}");
  overrides.push_back("camera=thesis_6mm_binned");  // hundreds of flights
  return overrides;
}

void AddHovers(const std::string& law, flight::SeedRange seeds, flight::SeedRange few, int jobs,
               std::vector<records::Figure>& table) {
  const auto flights = flight::FlyAll("servo", With({}, law), seeds, jobs, "servo, " + law);
  const std::string name = "servo " + law;
  const auto level = flight::Values(flights, "hold_horizontal_rmse_m"),
             height = flight::Values(flights, "hold_vertical_rmse_m");
  table.push_back({name + ", hover, horizontal RMSE", Rms(level), "m", 0.1, false, ""});
  table.push_back({name + ", hover, the worst flight", Largest(level), "m", {}, false, ""});
  table.push_back({name + ", hover, vertical RMSE", Rms(height), "m", 0.1, false, ""});
  table.push_back(
      {name + ", hover, latest settling", Largest(flight::Values(flights, "settle_s")), "s", {}, false, ""});
  const auto tilted =
      flight::FlyAll("servo", With({"flight.level_camera=false"}, law), few, jobs, "as seen, " + law);
  table.push_back({name + ", as seen by the tilting camera, horizontal RMSE",
                   Rms(flight::Values(tilted, "hold_horizontal_rmse_m")),
                   "m",
                   {},
                   false,
                   ""});
}

void AddTask(const Task& task, const std::string& law, flight::SeedRange seeds, int jobs, int& converged,
             int& flown) {
  std::vector<std::string> overrides = {"start.scatter_m=0", "start.yaw_scatter_deg=0", "duration_s=30"};
  overrides.insert(overrides.end(), task.start.begin(), task.start.end());
  const auto flights = flight::FlyAll("servo", With(overrides, law), seeds, jobs, task.name + ", " + law);
  std::string ends;
  for (const flight::FlownScenario& f : flights) {
    const bool there = f.summary.metrics.at("servo_converged") > 0;
    converged += there, ++flown;
    const std::string end = there                              ? "converged"
                            : f.summary.outcome == "completed" ? "not there"
                                                               : f.summary.outcome;
    if (ends.find(end) == std::string::npos) ends += (ends.empty() ? "" : ", ") + end;
  }
  const auto settled = flight::Values(flights, "settle_s");
  const auto finite = [](double s) { return std::isfinite(s); };
  const bool all = std::all_of(settled.begin(), settled.end(), finite);
  fmt::print("| {:<34} | {:<16} | {:<24} | {:>7} | {:>9.2f} | {:>9.2f} |\n", task.name, law, ends,
             all ? fmt::format("{:.1f}", Largest(settled)) : "",
             Largest(flight::Values(flights, "servo_retreat_m")),
             Largest(flight::Values(flights, "servo_advance_m")));
}

}  // namespace

void BenchServoFlights(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  const flight::SeedRange few{seeds.first, std::min(seeds.last, seeds.first + 1)};
  for (const std::string& law : mission::ServoLawNames()) AddHovers(law, seeds, few, jobs, table);
  fmt::print("| {:<34} | {:<16} | {:<24} | {:>7} | {:>9} | {:>9} |\n", "task", "law", "end", "time s",
             "retreat m", "advance m");
  fmt::print("|{:-<36}|{:-<18}|{:-<26}|{:->8}:|{:->10}:|{:->10}:|\n", "", "", "", "", "", "");
  for (const std::string& law : mission::ServoLawNames()) {
    int converged = 0, flown = 0, turned = 0, half_turns = 0;
    for (const Task& task : Tasks())
      AddTask(task, law, few, jobs, task.half_turn ? turned : converged, task.half_turn ? half_turns : flown);
    const std::string name = "servo " + law;
    table.push_back({name + ", tasks but half a turn, that converge", static_cast<double>(converged) / flown,
                     "share", 1, true, ""});
    const double share = static_cast<double>(turned) / half_turns;
    if (Stable(law)) {
      table.push_back({name + ", half a turn, that converge", share, "share", 1, true, "converges"});
    } else {
      table.push_back({name + ", half a turn, that converge", share, "share", {}, true, "does not"});
    }
  }
  fmt::print("\n");
}

void BenchDirect(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  for (const char* scenario : {"hover_direct", "hover_photometric"}) {
    const auto flights = flight::FlyAll(scenario, {}, seeds, jobs, scenario);
    const std::string name = scenario;
    const auto level = flight::Values(flights, "hold_horizontal_rmse_m"),
               height = flight::Values(flights, "hold_vertical_rmse_m"),
               direct = flight::Values(flights, "direct_share");
    table.push_back({name + ", 100 Hz, 10 ms, horizontal RMSE", Rms(level), "m", 0.1, false, "10 ms"});
    table.push_back({name + ", the worst flight", Largest(level), "m", {}, false, ""});
    table.push_back({name + ", vertical RMSE", Rms(height), "m", 0.1, false, ""});
    table.push_back({name + ", frames flown by rates and thrust, least",
                     *std::min_element(direct.begin(), direct.end()), "share", 0.98, true, ""});
  }
}

}  // namespace kestrel::bench
