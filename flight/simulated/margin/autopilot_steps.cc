// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/margin/autopilot_steps.h"

#include <cmath>
#include <functional>

#include "geometry/tait_bryan.h"

namespace kestrel::flight {
namespace {

constexpr double kHigh_m = 25;
constexpr double kSample_s = 0.02;
constexpr double kAnswer_s = 6;  // within which it has settled
constexpr int kSteps = 8;        // of each axis, four each way, after one that is not looked at

// flown: in the unit of asked, along it.
control::VelocityStep Step(sim::Simulator& simulator, double& t_s, const control::VelocitySetpoint& asked,
                           const std::function<double()>& flown) {
  const auto samples = static_cast<std::size_t>(std::lround(kAnswer_s / kSample_s));
  control::VelocityStep step{kSample_s, std::vector<double>(samples + 1, 0.0)};
  for (int i = 0; i <= kSteps; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    const double before = flown();
    for (std::size_t k = 0; k <= samples; ++k) {
      // From the way before to this one: a step of twice what is asked for.
      if (i > 0) step.answer[k] += sign * (flown() - before) / (2.0 * kSteps);
      simulator.Send(control::VelocitySetpoint{sign * asked.v_H, sign * asked.yaw_rate});
      t_s += kSample_s;
      while (simulator.NextUntil(t_s)) {}
    }
  }
  return step;
}

}  // namespace

AutopilotSteps StepAutopilot(const sim::SimulatorParameters& scenario) {
  sim::SimulatorParameters parameters = scenario;
  parameters.images = false;
  parameters.wind.mean_m_s = 0;
  parameters.wind.turbulence = false;
  parameters.wind.gusts.rate_per_min = 0;
  parameters.start.on_ground = false;
  parameters.start.height_m = kHigh_m;
  parameters.duration_s = 3 * (kSteps + 1) * (kAnswer_s + 2 * kSample_s) + 1;
  sim::Simulator simulator(parameters);
  double t_s = 0;
  // Beside the heading in which velocities are asked for the aircraft keeps that of its start.
  const Eigen::Vector3d ahead_N = HeadingRotation(YawOf(simulator.State().R_NB)) * Eigen::Vector3d::UnitX();
  constexpr double kStep = AutopilotSteps::kStep_m_s;
  const double turn = Radians(AutopilotSteps::kTurn_deg_s);
  AutopilotSteps steps;
  steps.level =
      Step(simulator, t_s, {{kStep, 0, 0}, 0}, [&] { return simulator.truth().v_N.dot(ahead_N) / kStep; });
  steps.climb = Step(simulator, t_s, {{0, 0, kStep}, 0}, [&] { return simulator.truth().v_N.z() / kStep; });
  steps.turn = Step(simulator, t_s, {{0, 0, 0}, turn}, [&] { return simulator.truth().w_B.z() / turn; });
  return steps;
}

}  // namespace kestrel::flight
