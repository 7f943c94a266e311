// SPDX-License-Identifier: Apache-2.0
#include "bench/landmark/bench_plane_pose.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "bench/landmark/plane_pose_study.h"
#include "bench/named_camera.h"
#include "geometry/tait_bryan.h"

namespace kestrel::bench {
namespace {

constexpr std::size_t kMethods = kPlanePoseMethods.size();

// Root mean squares over some of the trials.
struct Summary {
  int trials = 0;
  PoseSquares bound;
  std::array<PoseSquares, kMethods> error;
  std::array<int, kMethods> none{};

  void Add(const PlanePoseTrial& trial) {
    ++trials;
    bound.place_m2 += trial.bound.place_m2, bound.turn_rad2 += trial.bound.turn_rad2;
    for (std::size_t k = 0; k < kMethods; ++k) {
      none[k] += !trial.errors[k];
      if (!trial.errors[k]) continue;
      error[k].place_m2 += trial.errors[k]->place_m2, error[k].turn_rad2 += trial.errors[k]->turn_rad2;
    }
  }
  double BoundPlace_m() const { return std::sqrt(bound.place_m2 / trials); }
  double BoundTurn_deg() const { return Degrees(std::sqrt(bound.turn_rad2 / trials)); }
  // Of the poses that the method gave.
  double Place_m(std::size_t k) const { return std::sqrt(error[k].place_m2 / (trials - none[k])); }
  double Turn_deg(std::size_t k) const { return Degrees(std::sqrt(error[k].turn_rad2 / (trials - none[k]))); }
};

Summary Of(const std::vector<PlanePoseTrial>& trials,
           const std::function<bool(const PlanePoseTrial&)>& chosen) {
  Summary summary;
  for (const PlanePoseTrial& trial : trials)
    if (chosen(trial)) summary.Add(trial);
  return summary;
}

void Print(const std::string& name, const Summary& s) {
  if (s.trials == 0) return;
  fmt::print("| {:<20} | {:5} | {:8.2f} {:8.3f} |", name, s.trials, 1000 * s.BoundPlace_m(),
             s.BoundTurn_deg());
  for (std::size_t k = 0; k < kMethods; ++k)
    fmt::print(" {:6.2f} {:6.2f} |", s.Place_m(k) / s.BoundPlace_m(), s.Turn_deg(k) / s.BoundTurn_deg());
  fmt::print("\n");
}

}  // namespace

void BenchPlanePose(std::uint64_t seed, std::vector<records::Figure>& table) {
  PlanePoseStudy study;
  study.camera = std::get<vision::Pinhole>(NamedCamera("thesis_6mm"));
  const std::vector<PlanePoseTrial> trials = RunPlanePoseStudy(study, seed);
  fmt::print("| {:<20} | poses | bound mm  bound deg |", "RMSE / bound");
  for (const std::string& method : kPlanePoseMethods) fmt::print(" {:<13.13} |", method);
  fmt::print("\n");
  const auto by = [&](const char* unit, const std::vector<double>& edges, const auto& value) {
    for (std::size_t i = 0; i + 1 < edges.size(); ++i)
      Print(fmt::format("{:g} to {:g} {}", edges[i], edges[i + 1], unit),
            Of(trials,
               [&](const PlanePoseTrial& t) { return value(t) >= edges[i] && value(t) < edges[i + 1]; }));
  };
  by("m", {2, 4, 6, 9, 12}, [](const PlanePoseTrial& t) { return t.distance_m; });
  by("deg", {0, 10, 20, 35, 50, 70}, [](const PlanePoseTrial& t) { return Degrees(t.tilt_rad); });
  by("px", {0, 50, 100, 200, 1000}, [](const PlanePoseTrial& t) { return t.size_px; });
  const Summary all = Of(trials, [](const PlanePoseTrial&) { return true; });
  Print("all", all);
  fmt::print("\n");

  table.push_back({"plane pose: bound of the position's RMSE", all.BoundPlace_m(), "m", {}, false, ""});
  table.push_back({"plane pose: bound of the rotation's RMSE", all.BoundTurn_deg(), "deg", {}, false, ""});
  for (std::size_t k = 0; k < kMethods; ++k) {
    const std::string name = "plane pose, " + kPlanePoseMethods[k];
    const bool refined = k == kMethods - 1;
    const std::optional<double> target = refined ? std::optional(1.2) : std::nullopt;
    table.push_back({name + ": position RMSE", all.Place_m(k), "m", {}, false, ""});
    table.push_back(
        {name + ": and over the bound", all.Place_m(k) / all.BoundPlace_m(), "", target, false, ""});
    table.push_back({name + ": rotation RMSE", all.Turn_deg(k), "deg", {}, false, ""});
    table.push_back(
        {name + ": and over the bound", all.Turn_deg(k) / all.BoundTurn_deg(), "", target, false, ""});
    table.push_back({name + ": no pose", static_cast<double>(all.none[k]), "poses", {}, false, ""});
  }
}

}  // namespace kestrel::bench
