// SPDX-License-Identifier: Apache-2.0
#include "flight/served/serve_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <thread>

#include "base/real_time.h"
#include "base/stopwatch.h"
#include "flight/served/truth_judgement.h"
#include "flight/simulated/begin_live.h"
#include "flight/simulated/changes.h"
#include "flight/simulated/flight_records.h"
#include "flight/simulated/judgement.h"
#include "records/telemetry/flight_mode.h"
#include "records/video/drawn_view.h"
#include "vision/capture/live_camera.h"

namespace kestrel::flight {
namespace {

constexpr double kSlice_s = 0.002;
constexpr double kStands_s = 3;
constexpr char kLanded[] = "landed", kLasted[] = "completed";

// The simulator as the servers have it: bad numbers end here, as they would in front of a real autopilot's
// controllers.
class Overheard final : public control::Autopilot {
 public:
  explicit Overheard(sim::Simulator& simulator) : simulator_(simulator) {}
  control::VehicleState State() const override { return simulator_.State(); }
  void Send(const control::Setpoint& setpoint) override {
    if (!control::Finite(setpoint)) return;
    last = setpoint;
    simulator_.Send(setpoint);
  }
  void Aid(const control::AttitudeAid& aid) override {
    if (aid.R_NB.coeffs().allFinite()) simulator_.Aid(aid);
  }

  std::optional<control::Setpoint> last;  // since it was last taken

 private:
  sim::Simulator& simulator_;
};

class ServedFlight {
 public:
  ServedFlight(const LoadedScenario& loaded, const ServeOptions& options)
      : loaded_(loaded),
        options_(options),
        simulator_(loaded.simulator),
        aircraft_(simulator_),
        changes_(loaded, simulator_, nullptr, [this](const MadeChange& change) {
          if (options_.say)
            options_.say(fmt::format("{:9.3f} s  change: {} {} -> {}", change.t_s, change.key, change.before,
                                     change.value));
          if (records_) records_->Write(change, changes_.flown());
        }) {
    simulator_.CarryCamera(options.platform);
    told_.resize(options.servers.size());
    const std::string scene = options.folder || options.live ? SceneOf(loaded, simulator_) : "";
    if (options.folder) records_.emplace(*options.folder, loaded, simulator_, scene, false);
    if (!options.live) return;
    BeginLive(*options.live, loaded, simulator_, scene, PartsOf(loaded, simulator_.model()), changes_,
              records_ ? &*records_ : nullptr, "it flies at the pace of whoever is on the wires");
    if (records_)
      records_->Tell([live = options.live](double t_s, std::string_view what, std::string_view is) {
        live->Event(t_s, what, is);
      });
  }

  FlightResult Fly() {
    records::Summary& summary = result_.summary;
    summary = BeginSummary(loaded_.scenario);
    const double start_s = options_.clock.now_s();
    RealTime time(start_s);
    try {
      if (options_.begun) options_.begun();
      summary.outcome = Loop(time);
    } catch (const std::exception& e) {
      summary.outcome = "broke off";
      summary.error = e.what();
    }
    summary.complete = summary.error.empty();
    summary.wall_s = options_.clock.now_s() - start_s;
    AddSimulator(simulator_, summary);
    Assess(summary);
    Count(summary);
    summary.metrics["stretched_s"] = time.stretched_s();
    if (time.stretched_s() > 0)
      Tell("real time", fmt::format("the machine was too slow: time was stretched by {:.3f} s in all",
                                    time.stretched_s()));
    if (records_) summary = records_->Finish(summary, simulator_);
    if (options_.live) options_.live->End(summary);
    return std::move(result_);
  }

 private:
  double t_s() const { return simulator_.truth().t_s; }

  void Tell(const char* what, const std::string& is) {
    if (records_) records_->Note(t_s(), what, is);
    if (options_.say) options_.say(fmt::format("{:9.3f} s  {}: {}", t_s(), what, is));
  }

  std::string Loop(RealTime& time) {
    // The last frame comes its latency after the last exposure.
    const double end_s = loaded_.scenario.duration_s + loaded_.scenario.image.latency_s;
    double flew_s = t_s();
    while (t_s() < end_s - kSlice_s / 2) {
      if (options_.go_on && !options_.go_on()) return "ended from outside";
      const double now_s = options_.clock.now_s();
      const double due_s = time.Due(now_s, t_s());
      // However late: the servers receive and send in between.
      const double until_s = std::min({due_s, t_s() + kSlice_s, end_s});
      while (const auto frame = simulator_.NextUntil(until_s)) Receive(*frame);
      if (sim::SimulatedGroundCamera* ground = simulator_.ground_camera())
        while (const auto taken = ground->Take())
          if (options_.publish_ground) options_.publish_ground(taken->frame);
      if (options_.pilot_off_at_s && !pilot_off_ && t_s() >= *options_.pilot_off_at_s) {
        pilot_off_ = true;
        for (sim::AutopilotServer* server : options_.servers) server->SetPilot(false);
        Tell("pilot", "his switch takes the aircraft away");
      }
      for (sim::AutopilotServer* server : options_.servers) server->Serve(now_s, aircraft_);
      TellNews();
      if (const auto news_s = time.News(now_s))
        Tell("real time", fmt::format("the machine is too slow: {:.3f} s more behind, {:.3f} s in all; time "
                                      "is stretched, nothing is skipped",
                                      *news_s, time.stretched_s()));

      if (!(simulator_.touch() && simulator_.State().landed)) flew_s = t_s();
      if (t_s() >= flew_s + kStands_s) return kLanded;
      if (t_s() + kSlice_s > due_s) options_.clock.sleep_until(time.WallOf(t_s() + kSlice_s));
    }
    return kLasted;
  }

  bool Flown() const {
    return std::ranges::any_of(
        options_.servers, [](const sim::AutopilotServer* server) { return server->Received().followed > 0; });
  }

  // The first setpoint that is followed, and the first of each kind of what is ignored.
  void TellNews() {
    if (!flown_ && Flown()) {
      flown_ = true;
      Tell("client", "its first setpoint");
    }
    for (std::size_t i = 0; i < options_.servers.size(); ++i) {
      const auto& ignored = options_.servers[i]->Received().ignored;
      if (ignored.size() == told_[i].size()) continue;
      for (const auto& [kind, all] : ignored)
        if (told_[i].insert(kind).second) Tell("ignored", fmt::format("{}: {}", kind, all.first));
    }
  }

  void Count(records::Summary& summary) {
    sim::WireCounts sum;
    std::uint64_t ignored = 0;
    for (const sim::AutopilotServer* server : options_.servers) {
      const sim::WireCounts& counts = server->Received();
      sum.setpoints += counts.setpoints, sum.followed += counts.followed, sum.refused += counts.refused;
      for (const auto& [kind, all] : counts.ignored) {
        ignored += all.count;
        Tell("ignored", fmt::format("{} {} in all", all.count, kind));
      }
    }
    summary.metrics["setpoints_heard"] = static_cast<double>(sum.setpoints);
    summary.metrics["setpoints_followed"] = static_cast<double>(sum.followed);
    summary.metrics["setpoints_refused"] = static_cast<double>(sum.refused);
    summary.metrics["messages_not_heeded"] = static_cast<double>(ignored);
  }

  void Receive(const vision::Frame& frame) {
    if (options_.publish) options_.publish(frame);
    mission::Decision decision;
    decision.setpoint = std::exchange(aircraft_.last, std::nullopt);
    result_.rows.push_back(
        {frame.sequence, simulator_.exposure(), simulator_.truth(), simulator_.State(), decision});
    if (records_) records_->Write(result_.rows.back(), simulator_);
    changes_.MakeDue();
    if (options_.live) Show(*options_.live, frame);
  }

  void Show(Live& live, const vision::Frame& frame) {
    const records::LogRow& row = result_.rows.back();
    live.Row(row, live.WantsImage() ? frame.image : cv::Mat());
    if (live.WantsPicture(Picture::kOnBoard))
      live.Show(Picture::kOnBoard, row.now.t_s,
                records::DrawnView(frame, row.now.t_s, records::kSimulatorMode));
    live.Wait(row.now.t_s, [] { return true; });  // for no one: it makes the changes that are asked for
  }

  void Assess(records::Summary& summary) {
    JudgeByTruth(
        loaded_.scenario, result_.rows, simulator_.touch(),
        [this](const std::string& what) { Tell("judgement", what); }, summary);
    if (loaded_.scenario.criteria.empty() || Flown()) return;
    summary.passed = false;
    if (summary.outcome == kLasted || summary.outcome == kLanded) summary.outcome = "not flown";
    Tell("judgement", "no setpoint was followed: nobody flew it, and it has met nothing");
  }

  const LoadedScenario& loaded_;
  const ServeOptions& options_;
  sim::Simulator simulator_;
  Overheard aircraft_;
  Changes changes_;
  std::optional<FlightRecords> records_;
  FlightResult result_;
  std::vector<std::set<std::string>> told_;  // by server: the kinds of what was ignored
  bool pilot_off_ = false, flown_ = false;
};

}  // namespace

WallClock MonotonicClock() {
  return {MonotonicNow_s, [](double t_s) {
            const double left_s = t_s - MonotonicNow_s();
            if (left_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
          }};
}

FlightResult ServeFlight(const LoadedScenario& loaded, const ServeOptions& options) {
  LoadedScenario served = loaded;
  served.again.clear();  // who flew it is not in the scenario
  return ServedFlight(served, options).Fly();
}

}  // namespace kestrel::flight
