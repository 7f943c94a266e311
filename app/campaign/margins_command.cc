// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/margins_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/diagnostics.h"
#include "control/estimate/late_following.h"
#include "control/margin/loop_margins.h"
#include "flight/simulated/margin/autopilot_steps.h"
#include "flight/simulated/scenario.h"

namespace kestrel::app {
namespace {

// The margin that control/estimate/velocity_lag.h keeps too, and half as much again as the gain.
constexpr double kLeastPhase_deg = 30, kLeastGain = 1.5;
// By how much an autopilot is later than one that counts as prompt until a flight is sure of it.
constexpr double kSurely_s = 0.1;

struct ServoAxis {
  const char* name;
  const control::VelocityStep& answer;
  double lambda_per_s;
  double prompt_s;  // the lateness up to which the law does not reckon with it
};

bool ShowAxis(const ServoAxis& axis, double hold_s) {
  const double late_s = axis.answer.Late_s();
  const double reckoned_s = late_s > axis.prompt_s + kSurely_s ? late_s : 0;
  const control::ServoLoop loop{axis.lambda_per_s, reckoned_s, hold_s};
  const control::LoopMargins margins =
      control::Margins([&](double w) { return control::OpenLoop(axis.answer, loop, w); });
  const bool enough = margins.gain >= kLeastGain && margins.phase_deg >= kLeastPhase_deg;
  fmt::print("  {:<12}{:>8.3g}{:>9.2f}{:>15}{:>9.2f}{:>10.1f}{:>10.2f}   {}\n", axis.name, axis.lambda_per_s,
             late_s, reckoned_s > 0 ? "yes" : "no", margins.gain, margins.phase_deg, margins.delay_s,
             enough ? "ok" : "TOO LITTLE");
  return enough;
}

}  // namespace

CLI::App* AddMarginsCommand(CLI::App& app, MarginsArguments& a) {
  CLI::App* command = app.add_subcommand(
      "margins", "How far the gains of a flight over a pad are from swinging with its autopilot");
  command->add_option("file", a.file, "A name that `list` shows, or a YAML file")
      ->type_name("SCENARIO")
      ->required();
  command->add_option("--set", a.overrides, "key.path=value, as for run; may be repeated")
      ->type_name("KEY=VALUE");
  command->footer(fmt::format(
      "The autopilot flies steps of velocity in still air; what it answers makes the loop. Gain: by which "
      "times as much\nthe loop would swing. Phase: in degrees. Delay: the dead time more with which it "
      "would. "
      "Exit status 1: a gain\nbelow {:g} or a phase below {:g}.\n\nExamples:\n  kestrel margins landing\n"
      "  kestrel margins hover --set autopilot.climb_delay_s=0.85",
      kLeastGain, kLeastPhase_deg));
  return command;
}

bool MarginsCommand(const MarginsArguments& a) {
  const flight::LoadedScenario loaded = flight::LoadScenario(a.file, a.overrides);
  const flight::Scenario& scenario = loaded.scenario;
  if (!scenario.flight.type().looks_for_pad || scenario.carry)
    throw InputError(Place(a.file),
                     fmt::format("its mission {} servoes to no place over a pad by pilot.servo",
                                 scenario.flight.type().name),
                     "valid: a flight such as hover or landing");
  const flight::AutopilotSteps steps = flight::StepAutopilot(loaded.simulator);
  const control::ServoGains& gains = scenario.pilot.servo;
  using control::LateFollowing;
  const double hold_s = 1 / scenario.image.rate_hz;
  fmt::print("{}: answers to steps of {:g} m/s and {:g} deg/s\n", a.file,
             2 * flight::AutopilotSteps::kStep_m_s, 2 * flight::AutopilotSteps::kTurn_deg_s);
  fmt::print("  {:<12}{:>8}{:>9}{:>15}{:>9}{:>10}{:>10}\n", "axis", "lambda", "late, s", "reckoned with",
             "gain", "phase", "delay, s");
  bool enough = true;
  for (const ServoAxis& axis :
       {ServoAxis{"horizontal", steps.level, gains.lambda_per_s, LateFollowing::kPromptLevel_s},
        ServoAxis{"vertical", steps.climb, gains.lambda_vertical_per_s, LateFollowing::kPromptClimb_s},
        ServoAxis{"yaw", steps.turn, gains.lambda_yaw_per_s, 1e9}})
    enough = ShowAxis(axis, hold_s) && enough;
  return enough;
}

}  // namespace kestrel::app
