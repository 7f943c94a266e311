// SPDX-License-Identifier: Apache-2.0
#include "flight/stepped/sim.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "base/stopwatch.h"
#include "flight/simulated/changes.h"
#include "flight/simulated/judgement.h"
#include "records/telemetry/metrics.h"
#include "sim/camera/event/event_renderer.h"

namespace kestrel::flight {
namespace {

flight::LoadedScenario Load(const std::string& scenario, const SimOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  if (options.seed) overrides.push_back(fmt::format("seed={}", *options.seed));
  return flight::LoadScenario(scenario, overrides, false);  // the simulator compiles it
}

std::optional<double> ThrustOf(const control::Setpoint& setpoint) {
  if (const auto* attitude = std::get_if<control::AttitudeSetpoint>(&setpoint)) return attitude->thrust;
  if (const auto* rates = std::get_if<control::RateSetpoint>(&setpoint)) return rates->thrust;
  return std::nullopt;
}

}  // namespace

struct Sim::State {
  std::string name;
  SimOptions options;
  flight::LoadedScenario loaded;
  std::unique_ptr<sim::Simulator> simulator = nullptr;
  std::unique_ptr<mission::Mission> pilot = nullptr;  // the scenario's own; null: it was not asked
  std::unique_ptr<Changes> changes = nullptr;
  bool between = false;                     // a frame has come, and what is due then has not been changed yet
  std::optional<vision::Frame> frame = {};  // the last
  control::VehicleState estimate = {};      // when it came
  std::optional<mission::Decision> decision = {};  // on it
  sim::Readings readings = {};
  std::vector<sim::CameraFrame> camera_frames = {};
  std::vector<sim::Event> events = {};
  std::vector<records::LogRow> rows = {};
  std::chrono::steady_clock::time_point began = {};
  double asked_s = 0;  // how far Advance() was asked to go
  bool done = true;
  std::string outcome = {};

  void RequireFlight(const char* what) const {
    if (!simulator) throw SimError(fmt::format("{} before the flight has begun: call reset first", what));
    if (done)
      throw SimError(fmt::format("{} after the end of the flight ({}, at {:.3f} s): call reset first", what,
                                 outcome, simulator->truth().t_s));
  }

  void Send(const std::optional<control::Setpoint>& setpoint) {
    if (!setpoint) return;
    if (!control::Finite(*setpoint))
      throw SimError(
          fmt::format("at {:.3f} s: the setpoint has a number that is not one", simulator->truth().t_s));
    if (const std::optional<double> thrust = ThrustOf(*setpoint); thrust && (*thrust < 0 || *thrust > 1))
      throw SimError(fmt::format("at {:.3f} s: the setpoint has a thrust of {}: valid are 0 to 1",
                                 simulator->truth().t_s, *thrust));
    simulator->Send(*setpoint);
    if (!rows.empty()) rows.back().decision.setpoint = setpoint;
  }

  void End(std::string how) {
    if (sim::EventRenderer* camera = simulator->event_camera()) {
      camera->Finish();
      TakeEvents(*camera);
    }
    done = true;
    outcome = std::move(how);
    frame.reset();
  }

  void Forget() {
    readings = {};
    camera_frames.clear();
    events.clear();
  }

  void TakeEvents(sim::EventRenderer& camera) {
    const std::vector<sim::Event> more = camera.Take();
    events.insert(events.end(), more.begin(), more.end());
  }

  // The next frame, no later than until_s.
  std::optional<vision::Frame> Next(std::optional<double> until_s = std::nullopt) {
    try {
      if (std::exchange(between, false)) changes->MakeDue();
      auto next = until_s ? simulator->NextUntil(*until_s) : simulator->Next();
      sim::Append(readings, simulator->readings());
      const auto& frames = simulator->camera_frames();
      camera_frames.insert(camera_frames.end(), frames.begin(), frames.end());
      if (sim::EventRenderer* camera = simulator->event_camera()) TakeEvents(*camera);
      return next;
    } catch (...) {
      End("broke off");
      throw;
    }
  }

  Observation Observe(std::optional<vision::Frame> next) {
    Observation o{next, simulator->State(), {}, {}};
    decision.reset();
    frame = std::move(next);
    estimate = o.state;
    if (!frame) return o;
    between = true;
    o.surfaces = simulator->picture().surfaces;
    o.flow = simulator->picture().flow_here;
    rows.push_back({frame->sequence, simulator->exposure(), simulator->truth(), o.state, {}});
    return o;
  }
};

Sim::Sim(const std::string& scenario, const SimOptions& options)
    : state_(new State{.name = scenario, .options = options, .loaded = Load(scenario, options)}) {}
Sim::~Sim() = default;
Sim::Sim(Sim&&) noexcept = default;
Sim& Sim::operator=(Sim&&) noexcept = default;

Observation Sim::Reset(std::optional<std::uint64_t> seed) {
  State& s = *state_;
  if (seed && *seed != s.loaded.scenario.seed) {
    s.options.seed = seed;
    s.loaded = Load(s.name, s.options);
  }
  sim::SimulatorParameters parameters = s.loaded.simulator;
  parameters.images = s.options.images;
  parameters.surfaces = s.options.images && s.options.surfaces;
  parameters.draw_beside = s.options.draw_beside;
  if (s.options.imu && !parameters.instruments.imu) parameters.instruments.imu.emplace();
  if (s.options.events) parameters.events = s.loaded.scenario.event_camera;
  s.changes.reset();
  s.pilot.reset();
  s.simulator.reset();
  s.simulator = std::make_unique<sim::Simulator>(parameters);
  s.changes = std::make_unique<Changes>(s.loaded, *s.simulator, nullptr);
  s.between = false;
  s.Forget();
  s.rows.clear();
  s.outcome.clear();
  s.done = false;
  s.began = std::chrono::steady_clock::now();
  Observation first = s.Observe(s.Next());
  s.asked_s = t_s();
  if (!first.frame) s.End("completed");
  return first;
}

Observation Sim::Step(const std::optional<control::Setpoint>& setpoint,
                      const std::optional<control::AttitudeAid>& aid) {
  State& s = *state_;
  s.RequireFlight("a step");
  s.Forget();
  if (aid) s.simulator->Aid(*aid);
  s.Send(setpoint);
  if (s.decision && !s.decision->outcome.empty()) {  // the scenario's mission is over
    s.End(std::string(s.decision->outcome));
    return {std::nullopt, s.simulator->State(), {}, {}};
  }
  Observation next = s.Observe(s.Next());
  s.asked_s = t_s();
  if (!next.frame) s.End("completed");
  return next;
}

Observation Sim::Advance(double duration_s, const std::optional<control::Setpoint>& setpoint,
                         const std::function<bool()>& go_on) {
  State& s = *state_;
  s.RequireFlight("a step");
  if (!(duration_s > 0) || !std::isfinite(duration_s))
    throw SimError(fmt::format("a step of {} s: time goes on by a positive number of seconds", duration_s));
  s.Forget();
  s.Send(setpoint);
  s.asked_s += duration_s;
  const double end_s = s.loaded.simulator.duration_s;
  const bool ends = s.asked_s > end_s + dt_s() / 2;
  const double until_s = std::round(std::min(s.asked_s, end_s) / dt_s()) * dt_s();
  Observation o{std::nullopt, {}, {}, {}};
  while (auto frame = s.Next(until_s)) {
    o = s.Observe(std::move(frame));
    if (!go_on || go_on()) continue;
    s.asked_s = t_s();
    return o;
  }
  if (ends) {
    o = {};
    s.End("completed");
  }
  o.state = s.simulator->State();
  return o;
}

const mission::Decision& Sim::Decide() {
  State& s = *state_;
  s.RequireFlight("a decision");
  if (!s.frame || s.frame->image.empty())
    throw SimError(
        fmt::format("at {:.3f} s: the scenario's mission decides on a frame with an image, and there is none",
                    s.simulator->truth().t_s));
  if (s.decision) return *s.decision;
  if (!s.pilot) {
    mission::MissionParts parts = flight::PartsOf(s.loaded, s.simulator->model());
    if (parts.ground) parts.ground->stream = s.simulator->ground_camera();
    s.pilot = s.loaded.scenario.flight->Make(parts);
    s.changes->FlyBy(s.pilot.get());
  }
  s.decision = s.pilot->Step(*s.frame, s.estimate);
  s.rows.back().decision = *s.decision;
  return *s.decision;
}

void Sim::Change(const std::string& key, const std::string& value) {
  state_->RequireFlight("a change");
  const std::string why = state_->changes->Make(key, value);
  if (!why.empty()) throw SimError(fmt::format("at {:.3f} s: {}", t_s(), why));
}

const flight::Scenario& Sim::flown() const {
  simulator();
  return state_->changes->flown();
}

void Sim::Finish(const std::string& outcome) {
  state_->RequireFlight("an end");
  state_->End(outcome);
}

bool Sim::done() const { return state_->done; }
const std::string& Sim::outcome() const { return state_->outcome; }
double Sim::t_s() const { return simulator().truth().t_s; }
double Sim::dt_s() const { return simulator().model()->opt.timestep; }
const Truth& Sim::truth() const { return simulator().truth(); }
const Truth& Sim::exposure() const { return simulator().exposure(); }
const flight::LoadedScenario& Sim::scenario() const { return state_->loaded; }
const sim::Readings& Sim::readings() const { return state_->readings; }
const std::vector<sim::Event>& Sim::events() const {
  if (!state_->options.events) throw SimError("this Sim has no event camera; make it with the option events");
  return state_->events;
}
const std::vector<sim::CameraFrame>& Sim::camera_frames() const { return state_->camera_frames; }
const std::vector<records::LogRow>& Sim::rows() const { return state_->rows; }

const sim::Simulator& Sim::simulator() const {
  if (!state_->simulator) throw SimError("the flight has not begun: call reset first");
  return *state_->simulator;
}

records::Summary Sim::Summarise() const {
  const State& s = *state_;
  const sim::Simulator& sim = simulator();
  records::Summary summary = flight::BeginSummary(s.loaded.scenario);
  summary.outcome = s.outcome.empty() ? "under way" : s.outcome;
  summary.complete = s.done;
  summary.wall_s = SecondsSince(s.began);
  flight::AddSimulator(sim, summary);
  summary.metrics = records::Metrics(s.rows, sim.touch(), &s.loaded.scenario.flight.type());
  flight::Judge(s.loaded.scenario.criteria, summary);
  summary.passed =
      summary.complete && (!s.pilot || s.pilot->Accomplished()) && flight::AllPassed(summary.criteria);
  return summary;
}

}  // namespace kestrel::flight
