// SPDX-License-Identifier: Apache-2.0
#include "bench/servo/bench_servoing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/statistics.h"

namespace kestrel::bench {
namespace {

struct Mean95 {
  double mean = 0, half_width = 0;  // of the 95 % interval
};

// Of paired differences, by Student's t, whose 97.5 % quantile is 1.96 + 2.4 / freedom to a hundredth from 8
// degrees of freedom on.
Mean95 MeanOfDifferences(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i) differences.push_back(a[i] - b[i]);
  const double mean = Mean(differences), n = static_cast<double>(differences.size());
  double variance = 0;
  for (const double d : differences) variance += (d - mean) * (d - mean) / (n - 1);
  return {mean, (1.96 + 2.4 / (n - 1)) * std::sqrt(variance / n)};
}

double MinOf(std::vector<double> values) { return *std::min_element(values.begin(), values.end()); }

}  // namespace

void BenchFollow(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  const auto add = [&](const std::string& name, double value, const char* unit,
                       std::optional<double> target = {}, bool at_least = false, const char* thesis = "") {
    table.push_back({name, value, unit, target, at_least, thesis});
  };
  const auto fly = [&](const char* scenario, const std::string& law, std::vector<std::string> overrides) {
    overrides.push_back("flight.law=" + law);
    return flight::FlyAll(scenario, overrides, seeds, jobs, fmt::format("{}, {}", scenario, law));
  };
  for (const std::string law : {"coupled", "decoupled"}) {
    const auto flights = fly("follow_step", law, {});
    const std::string name = "step of u, calm, " + law;
    add(name + ": settling to 5 %, worst", Largest(flight::Values(flights, "step_u_settle_s")), "s", 3, false,
        "not given");
    add(name + ": overshoot, worst", 100 * Largest(flight::Values(flights, "step_u_overshoot")), "%", 10,
        false, "visible");
    add("step of diameter, calm, " + law + ": distance error, worst",
        100 * Largest(flight::Values(flights, "step_distance_error")), "%", 5, false, "visible");
  }
  for (const std::string law : {"coupled", "decoupled"}) {
    const auto flights = fly("follow_step", law, {"wind.mean_m_s=3", "wind.turbulence=true", "criteria={}"});
    const auto u = flight::Values(flights, "follow_u_rms_px");
    add("steady, 3 m/s wind, " + law + ": u, RMS of all", Rms(u), "px", 4);
    add("steady, 3 m/s wind, " + law + ": u, the worst flight", Largest(u), "px");
    add("steady, 3 m/s wind, " + law + ": v, RMS of all", Rms(flight::Values(flights, "follow_v_rms_px")),
        "px");
  }
  for (const int speed : {1, 2}) {
    std::vector<std::vector<double>> u, distance;
    for (const std::string law : {"coupled", "decoupled"}) {
      const auto flights = fly("follow", law, {fmt::format("targets.0.roam_m_s={}", speed)});
      const std::string name = fmt::format("paths to {} m/s, {}", speed, law);
      const auto in_view = flight::Values(flights, "in_view_share");
      add(name + ": in view, mean", 100 * Mean(in_view), "%", speed == 1 ? 99 : 95, true, "followed");
      add(name + ": in view, the worst flight", 100 * MinOf(in_view), "%");
      u.push_back(flight::Values(flights, "follow_u_rms_px")),
          distance.push_back(flight::Values(flights, "follow_distance_rms"));
      add(name + ": distance, RMS of all", 100 * Rms(distance.back()), "%", 10);
      add(name + ": distance, the worst flight", 100 * Largest(distance.back()), "%");
      add(name + ": u, RMS of all", Rms(u.back()), "px");
    }
    if (seeds.last - seeds.first < 2) continue;
    const std::string name = fmt::format("paths to {} m/s, decoupled less coupled", speed);
    const Mean95 in_u = MeanOfDifferences(u[1], u[0]),
                 in_distance = MeanOfDifferences(distance[1], distance[0]);
    add(name + ": u, RMS, mean", in_u.mean, "px", {}, false, "unimportant");
    add(name + ": u, RMS, 95 % interval, +-", in_u.half_width, "px");
    add(name + ": distance, RMS, mean", 100 * in_distance.mean, "%", {}, false, "unimportant");
    add(name + ": distance, RMS, 95 % interval, +-", 100 * in_distance.half_width, "%");
  }
}

void BenchFollowSteps(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  struct Rung {
    const char* name;
    std::vector<std::string> adds;
  };
  const std::vector<Rung> rungs = {
      {"thesis", {}},
      {"+ level camera", {"flight.features.level=true"}},
      {"+ outline", {"flight.features.outline=true"}},
      // With the gains that it allows.
      {"+ prediction", {"flight.features.filter=true", "gains=gains/prompt.yaml"}},
      {"+ target's velocity", {"flight.gains.feed_forward=true"}},
  };
  const auto add = [&](const std::string& name, double value, const char* unit,
                       std::optional<double> target = {}) {
    table.push_back({name, value, unit, target, true, target ? "followed" : ""});
  };
  std::vector<std::string> overrides = {"criteria={}"};
  std::vector<flight::FlownScenario> coupled;
  for (const Rung& rung : rungs) {
    overrides.insert(overrides.end(), rung.adds.begin(), rung.adds.end());
    auto flights = flight::FlyAll("follow_thesis", overrides, seeds, jobs, rung.name);
    const std::string name = std::string("following, ") + rung.name;
    const auto in_view = flight::Values(flights, "in_view_share");
    add(name + ": in view, mean", 100 * Mean(in_view), "%", 95);
    add(name + ": in view, the worst flight", 100 * MinOf(in_view), "%");
    add(name + ": distance, RMS of all", 100 * Rms(flight::Values(flights, "follow_distance_rms")), "%");
    add(name + ": u, RMS of all", Rms(flight::Values(flights, "follow_u_rms_px")), "px");
    add(name + ": v, RMS of all", Rms(flight::Values(flights, "follow_v_rms_px")), "px");
    if (coupled.empty()) coupled = std::move(flights);
  }
  const auto decoupled = flight::FlyAll("follow_thesis", {"criteria={}", "flight.law=decoupled"}, seeds, jobs,
                                        "thesis, decoupled");
  const std::string name = "following, thesis, decoupled less coupled";
  add("following, thesis, decoupled: in view, mean", 100 * Mean(flight::Values(decoupled, "in_view_share")),
      "%", 95);
  if (seeds.last - seeds.first < 2) return;
  struct Metric {
    const char *metric, *what, *unit;
    double factor;
  };
  for (const Metric& m : {Metric{"in_view_share", "in view", "%", 100},
                          {"follow_u_rms_px", "u, RMS", "px", 1},
                          {"follow_v_rms_px", "v, RMS", "px", 1},
                          {"follow_distance_rms", "distance, RMS", "%", 100}}) {
    const Mean95 d =
        MeanOfDifferences(flight::Values(decoupled, m.metric), flight::Values(coupled, m.metric));
    add(fmt::format("{}: {}, mean", name, m.what), m.factor * d.mean, m.unit);
    add(fmt::format("{}: {}, 95 % interval, +-", name, m.what), m.factor * d.half_width, m.unit);
  }
}

void BenchAvoidSight(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  for (const double right_m : {0.6, 1.2, -0.6, -1.2}) {
    const auto fly = [&](const char* scenario, const std::string& title) {
      return flight::FlyAll(scenario,
                            {fmt::format("targets.0.position_m=[8.5, {}, 4]", right_m), "criteria={}"}, seeds,
                            jobs, title);
    };
    const std::string place =
        fmt::format("mark {:g} m to the {}", std::abs(right_m), right_m > 0 ? "right" : "left");
    const auto flights = fly("avoid_sight", "by sight, " + place);
    table.push_back({"by bearing alone, " + place + ": closest distance, worst",
                     MinOf(flight::Values(flights, "closest_m")), "m", 2, true, "> 2R"});
    const auto by_growth =
        flight::FlyAll(right_m > 0 ? (right_m > 1 ? "avoid_left_2" : "avoid_left_1")
                                   : (right_m < -1 ? "avoid_right_2" : "avoid_right_1"),
                       {"flight.decides_by=growth", "flight.avoidance.max_bearing_deg=90", "criteria={}"},
                       seeds, jobs, "by growth, " + place);
    table.push_back({"by growth and bearing rate, " + place + ": closest distance, worst",
                     MinOf(flight::Values(by_growth, "closest_m")), "m", 2, true, "> 2R"});
  }
}

void BenchAvoid(flight::SeedRange seeds, int jobs, std::vector<records::Figure>& table) {
  for (const char* scenario : {"avoid_left_1", "avoid_left_2", "avoid_right_1", "avoid_right_2"}) {
    const auto flights = flight::FlyAll(scenario, {}, seeds, jobs, scenario);
    const std::string name = scenario;
    table.push_back({name + ": closest distance, worst", MinOf(flight::Values(flights, "closest_m")), "m", 2,
                     true, "> 2R"});
    table.push_back({name + ": share of what 50 degrees allow, worst",
                     MinOf(flight::Values(flights, "closest_share")), "", 0.9, true, ""});
    table.push_back({name + ": from the course at the end, worst",
                     Largest(flight::Values(flights, "course_end_m")), "m", 1, false, "no end"});
    table.push_back({name + ": the same by its own position, worst",
                     Largest(flight::Values(flights, "course_end_own_m")), "m", 1, false, "no end"});
    table.push_back({name + ": outcome is the goal",
                     100 * Mean([&] {
                       std::vector<double> reached;
                       for (const flight::FlownScenario& f : flights)
                         reached.push_back(f.summary.outcome == "goal reached");
                       return reached;
                     }()),
                     "%", 100, true, ""});
  }
}

}  // namespace kestrel::bench
