// SPDX-License-Identifier: Apache-2.0
#include "bench/servo/bench_servo.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/diagnostics.h"
#include "bench/servo/servo_tasks.h"
#include "flight/simulated/scenario.h"
#include "vision/camera/calibration_file.h"
#include "vision/camera/camera_model.h"

namespace kestrel::bench {
namespace {

vision::Pinhole ThesisCamera() {
  Mistakes mistakes;
  const vision::CameraModel camera =
      vision::LoadCamera(Root() / "models" / "cameras" / "thesis_6mm.yaml", mistakes);
  mistakes.ThrowIfAny();
  return std::get<vision::Pinhole>(camera);
}

void PrintTrial(const std::string& task, ServoLaw law, const ServoTrial& t) {
  fmt::print("| {:<36} | {:<20} | {:<9} | {:>7} | {:>8.2g} | {:>9.0f} | {:<4} | {:>9.2f} |\n", task,
             NameOf(law), NameOf(t.end),
             t.end == ServoEnd::kConverged ? fmt::format("{:.2f}", t.converged_s) : "", t.final_px,
             t.excursion_px, t.in_view ? "" : "left", t.retreat_m);
}

}  // namespace

void BenchServo(std::vector<records::Figure>& table) {
  const ServoTrialOptions options{.camera = ThesisCamera()};
  const std::vector<ServoTask> tasks = ServoTasks();
  const std::vector<ServoLaw> laws = ServoLaws();
  fmt::print("| {:<36} | {:<20} | {:<9} | {:>7} | {:>8} | {:>9} | {:<4} | {:>9} |\n", "task", "law", "end",
             "time s", "final px", "excurs px", "view", "retreat m");
  fmt::print("|{:-<38}|{:-<22}|{:-<11}|{:->8}:|{:->9}:|{:->10}:|{:-<6}|{:->10}:|\n", "", "", "", "", "", "",
             "", "");
  std::vector<ServoTrial> all;
  for (const ServoTask& task : tasks) {
    int converged = 0;
    for (const ServoLaw law : laws) {
      const ServoTrial trial = FlyServoTask(task, law, options);
      PrintTrial(task.name, law, trial);
      converged += trial.end == ServoEnd::kConverged;
      all.push_back(trial);
    }
    table.push_back({"servo, " + task.name + ": laws that converge", static_cast<double>(converged), "laws",
                     1, true, ""});
  }
  fmt::print("\n");
  for (std::size_t l = 0; l < laws.size(); ++l) {
    int converged = 0, in_view = 0;
    double slowest = 0, retreat = 0;
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const ServoTrial& trial = all[t * laws.size() + l];
      if (trial.end != ServoEnd::kConverged) continue;
      ++converged;
      in_view += trial.in_view;
      slowest = std::max(slowest, trial.converged_s);
      retreat = std::max(retreat, trial.retreat_m);
    }
    const std::string name = fmt::format("servo, {}", NameOf(laws[l]));
    const double n = static_cast<double>(tasks.size());
    table.push_back({name + ": tasks that converge", converged / n, "share", {}, true, ""});
    table.push_back({name + ": and keep all points in view", in_view / n, "share", {}, true, ""});
    table.push_back({name + ": slowest of them", slowest, "s", {}, false, ""});
    table.push_back({name + ": largest retreat of them", retreat, "m", {}, false, ""});
  }
}

}  // namespace kestrel::bench
