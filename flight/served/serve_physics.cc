// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_physics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "base/stopwatch.h"
#include "flight/served/truth_judgement.h"
#include "flight/simulated/changes.h"
#include "flight/simulated/flight_records.h"
#include "flight/simulated/judgement.h"
#include "records/telemetry/flight_mode.h"
#include "records/video/drawn_view.h"
#include "sim/server/physics/ardupilot_physics.h"
#include "sim/server/physics/px4_physics.h"

namespace kestrel::flight {
namespace {

constexpr double kLeft_m = 0.1;     // above where it stood, off the ground: it flies
constexpr double kCrash_m_s = 1.5;  // into the ground; what legs are built for

std::filesystem::path FurtherFolder(const std::filesystem::path& first, std::size_t number) {
  std::filesystem::path plain = first.has_filename() ? first : first.parent_path();  // of "DIR/"
  return plain += fmt::format("-{}", number);
}

// One flight, from its autopilot's first word to its last.
class FlightByPhysics {
 public:
  FlightByPhysics(const LoadedScenario& loaded, sim::PhysicsServer& server, const PhysicsOptions& options,
                  const std::optional<std::filesystem::path>& folder)
      : loaded_(loaded),
        options_(options),
        simulator_(loaded.simulator),
        stood_m_(Height_m()),
        changes_(loaded, simulator_, nullptr, [this](const MadeChange& change) {
          if (options_.say)
            options_.say(fmt::format("{:9.3f} s  change: {} {} -> {}", change.t_s, change.key, change.before,
                                     change.value));
          if (records_) records_->Write(change, changes_.flown());
        }) {
    simulator_.FlyBy(&server);
    if (!folder) return;
    records_.emplace(*folder, loaded, simulator_, SceneOf(loaded, simulator_), options.video);
    records_->Note(0, "autopilot",
                   fmt::format("it has its sensors at {}, and moves the rotors itself{}", server.Where(),
                               loaded.simulator.step_s
                                   ? fmt::format("; physics of {:g} Hz", 1 / *loaded.simulator.step_s)
                                   : ""));
  }

  PhysicsFlight Fly() {
    PhysicsFlight flight{BeginSummary(loaded_.scenario), false};
    records::Summary& summary = flight.summary;
    const double begun_s = MonotonicNow_s();
    try {
      while (const auto frame = simulator_.Next()) Receive(*frame);
      summary.outcome = options_.stopped() ? "ended from outside" : "the autopilot left";
      if (simulator_.touch() && simulator_.truth().touching)
        summary.outcome = "landed";
      else if (!simulator_.truth().touching)
        summary.outcome += ", in the air";
    } catch (const std::exception& e) {
      summary.outcome = "broke off";
      summary.error = e.what();
    }
    summary.complete = summary.error.empty();
    summary.wall_s = MonotonicNow_s() - begun_s;
    AddSimulator(simulator_, summary);
    JudgeByTruth(
        loaded_.scenario, Judged(), simulator_.touch(),
        [this](const std::string& what) { Tell("judgement", what); }, summary);
    flight.flown = left_ || simulator_.touch();
    if (summary.complete && simulator_.touch() && simulator_.touch()->v_N.z() > kCrash_m_s) {
      summary.passed = false;
      summary.outcome = "crashed";
      Tell("judgement", fmt::format("it hit the ground by {:.1f} m/s, more than {:g}",
                                    simulator_.touch()->v_N.z(), kCrash_m_s));
    }
    if (summary.complete && !flight.flown) {
      summary.passed = false;
      summary.outcome = "not flown";
      Tell("judgement", "the aircraft never left the ground: it has met nothing");
    }
    if (records_) summary = records_->Finish(summary, simulator_);
    return flight;
  }

 private:
  double Height_m() const { return simulator_.truth().X_NT.p.z() - simulator_.truth().X_NB.p.z(); }

  void Tell(const char* what, const std::string& is) {
    if (records_) records_->Note(simulator_.truth().t_s, what, is);
    if (options_.say) options_.say(fmt::format("{:9.3f} s  {}: {}", simulator_.truth().t_s, what, is));
  }

  void Receive(const vision::Frame& frame) {
    if (options_.publish) options_.publish(frame);
    const Truth& truth = simulator_.truth();
    left_ = left_ || (!truth.touching && Height_m() > stood_m_ + kLeft_m);
    last_.emplace();
    last_->sequence = frame.sequence;
    last_->exposure = simulator_.exposure();
    last_->now = truth;
    last_->heard = false;
    last_->estimate.t_s = truth.t_s;
    last_->estimate.landed = truth.touching;
    const double down = (truth.X_NB.R * Eigen::Vector3d::UnitZ()).z();
    if (!most_tilted_ || down < least_down_) most_tilted_ = last_, least_down_ = down;
    if (records_) {
      records_->Write(*last_, simulator_);
      if (records_->recorder().wants_images())
        records_->recorder().WriteImage(records::DrawnView(frame, last_->now.t_s, records::kSimulatorMode));
    }
    changes_.MakeDue();
  }

  // What the metrics of the truth look at: of a flight that may last for days, no more is kept.
  std::vector<records::LogRow> Judged() const {
    if (!last_) return {};
    return {*most_tilted_, *last_};
  }

  const LoadedScenario& loaded_;
  const PhysicsOptions& options_;
  sim::Simulator simulator_;
  const double stood_m_;
  Changes changes_;
  std::optional<FlightRecords> records_;
  std::optional<records::LogRow> most_tilted_, last_;
  double least_down_ = 0;
  bool left_ = false;
};

}  // namespace

std::unique_ptr<sim::PhysicsServer> MakePhysics(const std::string& kind, const std::string& address,
                                                const std::optional<int>& port,
                                                const LoadedScenario& loaded) {
  const auto make = [&]<class Server, class Parameters>(Parameters parameters) {
    parameters.address = address;
    if (port) parameters.port = *port;
    return std::make_unique<Server>(parameters, loaded.simulator.vehicle);
  };
  if (kind == "px4") return make.template operator()<sim::Px4Physics>(sim::Px4PhysicsParameters{});
  return make.template operator()<sim::ArduPilotPhysics>(sim::ArduPilotPhysicsParameters{});
}

void CheckPhysicsFaults(const std::string& kind, const LoadedScenario& loaded, Mistakes& mistakes) {
  const sim::SensorParameters& sensors = loaded.simulator.sensors;
  for (std::size_t i = 0; i < sensors.attitude_faults.size(); ++i)
    mistakes.Add("--physics", fmt::format("sensors.attitude_faults.{}", i),
                 "is of the emulated autopilot's attitude; this autopilot estimates its own",
                 "valid: sensors.faults of gyro or accel");
  if (kind != "ardupilot") return;
  for (std::size_t i = 0; i < sensors.faults.size(); ++i) {
    const sim::SensorFault& fault = sensors.faults[i];
    if (fault.type == "ok" || fault.component == "gyro" || fault.component == "accel") continue;
    mistakes.Add("--physics", fmt::format("sensors.faults.{}.component", i),
                 fmt::format("{}: ArduPilot makes this sensor from the truth, so its fault cannot reach it",
                             fault.component),
                 "valid: gyro, accel; or a fault of ArduPilot's own by its SIM_ parameters");
  }
}

std::vector<PhysicsFlight> ServePhysics(const LoadedScenario& loaded, sim::PhysicsServer& server,
                                        const PhysicsOptions& options) {
  LoadedScenario served = loaded;
  served.again.clear();  // who flew it is not in the scenario
  sim::SimulatorParameters& parameters = served.simulator;
  parameters.start.on_ground = true;
  parameters.start.settle_s = 1;
  // It ends with the autopilot, or the server: an aircraft in the air is not put back to its start.
  parameters.duration_s = std::numeric_limits<double>::infinity();
  // What nobody sees is not drawn.
  parameters.images = options.publish || (options.folder && options.video);
  parameters.ground.reset();
  parameters.events.reset();
  std::vector<PhysicsFlight> flights;
  sim::PhysicsCounts told;
  const auto say = [&](const std::string& text) {
    if (options.say) options.say(text);
  };
  const auto waits = [&] {
    say("waits for an autopilot");
    return server.Begin();
  };
  while ((flights.empty() || flights.back().summary.complete) && waits()) {
    const std::size_t number = flights.size() + 1;
    parameters.step_s = server.step_s();
    say(fmt::format("flight {}: an autopilot is there{}", number,
                    parameters.step_s ? fmt::format("; physics of {:g} Hz", 1 / *parameters.step_s) : ""));
    std::optional<std::filesystem::path> folder = options.folder;
    if (folder && number > 1) folder = FurtherFolder(*folder, number);
    flights.push_back(FlightByPhysics(served, server, options, folder).Fly());
    const sim::PhysicsCounts counts = server.counts();
    say(fmt::format("flight {}: over after {:.1f} s; {} answers, {} repeated, {} refused", number,
                    flights.back().summary.sim_s, counts.answers - told.answers,
                    counts.repeated - told.repeated, counts.refused - told.refused));
    told = counts;
    if (options.over) options.over(flights.back().summary, folder);
  }
  return flights;
}

int StatusOf(const std::vector<PhysicsFlight>& flights) {
  if (std::ranges::any_of(flights, [](const PhysicsFlight& f) { return !f.summary.complete; })) return 3;
  const auto flown = [](const PhysicsFlight& f) { return f.flown; };
  const bool met =
      std::ranges::all_of(flights, [](const PhysicsFlight& f) { return !f.flown || f.summary.passed; });
  return met && std::ranges::any_of(flights, flown) ? 0 : 1;
}

}  // namespace kestrel::flight
