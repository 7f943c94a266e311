// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "control/margin/loop_margins.h"
#include "sim/simulator.h"

namespace kestrel::flight {

// How the autopilot of a scenario answers velocities, by the truth: the mean of its answers to steps there and
// back of kStep_m_s and kTurn_deg_s, in still air.
struct AutopilotSteps {
  static constexpr double kStep_m_s = 0.3;  // from one way to the other: twice as much
  static constexpr double kTurn_deg_s = 10;

  control::VelocityStep level, climb, turn;
};

// Flies them without images, high over the scenario's world, in a good minute of simulated time.
AutopilotSteps StepAutopilot(const sim::SimulatorParameters& simulator);

}  // namespace kestrel::flight
