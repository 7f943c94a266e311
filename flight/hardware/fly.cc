// SPDX-License-Identifier: Apache-2.0
#include "flight/hardware/fly.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "base/background_writer.h"
#include "base/stopwatch.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "flight/flight_subject.h"
#include "flight/hardware/control_monitor.h"
#include "flight/hardware/lag_monitor.h"
#include "flight/hardware/sighting_of.h"
#include "flight/load_plugins.h"
#include "mission/flight_loop.h"
#include "records/recorder.h"
#include "records/recording.h"
#include "records/summary.h"
#include "records/telemetry/event_log.h"
#include "records/telemetry/flight_mode.h"
#include "records/video/drawn_view.h"
#include "vision/write_image.h"

namespace kestrel::flight {
namespace {

// The camera of a flight that somebody may end, or that has lasted long enough.
class UntilStopped final : public vision::Camera {
 public:
  // waiting: called while no image comes.
  UntilStopped(vision::LiveCamera& camera, double until_s, const std::atomic<bool>* interrupted,
               std::function<void()> waiting, std::function<void(const vision::Frame&)> seen)
      : camera_(camera),
        until_s_(until_s),
        interrupted_(interrupted),
        waiting_(std::move(waiting)),
        seen_(std::move(seen)) {}

  std::optional<vision::Frame> Next() override {
    for (;;) {
      if (interrupted_ && *interrupted_) return End("interrupted");
      if (MonotonicNow_s() >= until_s_) return End(ControlMonitor::kTimeIsUp);
      auto frame = camera_.Next(0.05);
      if (frame) {
        given_s_ = MonotonicNow_s();
        if (seen_) seen_(*frame);
        return frame;
      }
      if (camera_.Health().state == vision::LiveCameraState::kEnded) return End("camera ended");
      waiting_();
    }
  }
  double given_s() const { return given_s_; }  // when the last frame was there
  const std::string& why() const { return why_; }

 private:
  std::optional<vision::Frame> End(const char* why) {
    why_ = why;
    return std::nullopt;
  }

  vision::LiveCamera& camera_;
  double until_s_;
  const std::atomic<bool>* interrupted_;
  std::function<void()> waiting_;
  std::function<void(const vision::Frame&)> seen_;
  double given_s_ = 0;
  std::string why_;
};

// The autopilot as the mission has it. Of one that was never heard nothing is known: not that it stands on
// the ground, as a VehicleState{} says.
class AsHeard final : public control::Autopilot {
 public:
  AsHeard(control::SafeAutopilot& safe, const control::AutopilotLink& link) : safe_(safe), link_(link) {}

  control::VehicleState State() const override {
    const bool heard_before = heard();
    control::VehicleState state = safe_.State();
    if (!heard_before) state.landed = false;
    return state;
  }
  void Send(const control::Setpoint& setpoint) override { safe_.Send(setpoint); }
  void Aid(const control::AttitudeAid& aid) override { safe_.Aid(aid); }
  bool heard() const {
    return heard_ = heard_ || (link_.Health().state_age_s && control::Finite(link_.State()));
  }

 private:
  control::SafeAutopilot& safe_;
  const control::AutopilotLink& link_;
  mutable bool heard_ = false;
};

// What a dry run went without; the safety layer, silent for the pilot's sake, says nothing of it.
struct Losses {
  bool images = false, state = false;

  // Ages of the newest ones in s; while there is none, of the run.
  void Note(double image_age_s, double state_age_s, const control::SafetyLimits& limits) {
    images = images || image_age_s > limits.image_s;
    state = state || state_age_s > limits.state_s;
  }
  std::string Text() const {
    return fmt::format("{}{}", images ? "; images were lost" : "", state ? "; the state was lost" : "");
  }
};

records::TelemetryOptions TelemetryOf(const LoadedPlan& plan) {
  return {.truth = false, .safety = true, .mission = &plan.plan.flight.type()};
}

records::FlightSubject FlownSubject(const LoadedPlan& plan, const std::string& mode) {
  records::FlightSubject subject = SubjectOf(plan.plan, plan.parts, mode, plan.description);
  subject.rate_hz = plan.plan.image.rate_hz;
  return subject;
}

// The folder of a real flight: as a simulated one's, without what only a simulator knows.
class Records {
 public:
  Records(const std::filesystem::path& folder, const LoadedPlan& plan, const FlyOptions& o,
          const std::string& mode, double begun_s)
      : events_((std::filesystem::create_directories(folder), folder)) {
    records::RecorderOptions options;
    options.video = o.video;
    options.rate_hz = plan.plan.image.rate_hz;
    options.plots.title = fmt::format("{}, {}", mode, plan.plan.name);
    options.telemetry = TelemetryOf(plan);
    recorder_.emplace(folder, options);
    WriteFile(folder / "scenario.yaml", ToYaml(plan.plan));
    records::WriteSubject(folder, FlownSubject(plan, mode));
    if (o.images) {
      recording_.emplace(folder, plan.plan.flight.type());
      records::WriteOwnParts(folder, plan.parts.own_parts);
    }
    events_.Line(0, "mode", mode);
    if (!o.aircraft.empty()) WriteFile(folder / "aircraft.yaml", o.aircraft);
    for (const auto& [what, is] : o.flown_with) events_.Line(0, what, is);
    // So that records of other programs on this computer can be laid beside them.
    events_.Line(0, "clock", fmt::format("{:.6f} s of the monotonic clock", begun_s));
  }

  void Write(const std::vector<control::SafetyChange>& changes, double begun_s) {
    for (const control::SafetyChange& c : changes)
      events_.Line(c.t_s - begun_s, "safety",
                   fmt::format("{}, {}{}", control::NameOf(c.hazard), control::NameOf(c.reaction),
                               c.limited ? ", limited" : ""));
  }
  void Write(const records::LogRow& row) {
    recorder_->Write(row);
    events_.Write(row);
  }
  void Tell(records::EventListener listener) { events_.Tell(std::move(listener)); }
  void Line(double t_s, const char* what, const std::string& text) { events_.Line(t_s, what, text); }
  void WriteImages(const cv::Mat& drawn, const cv::Mat& product) {
    recorder_->WriteImage(drawn);
    recorder_->WriteProduct(product);
  }
  void Record(const vision::Frame& frame, const control::VehicleState& state,
              const mission::Decision& decision) {
    if (recording_) recording_->Write(frame, state, decision);
  }
  void Finish(const records::Summary& summary) {
    if (recording_) recording_->Close();
    events_.End(summary.sim_s, summary.error.empty() ? summary.outcome : summary.error);
    recorder_->Finish(summary);
  }

 private:
  records::EventLog events_;
  std::optional<records::Recorder> recorder_;
  std::optional<records::RecordingWriter> recording_;
};

records::Summary SummaryOf(const LoadedPlan& plan, const std::string& mode) {
  records::Summary summary;
  summary.scenario = plan.plan.name;
  summary.version = Version();
  summary.plugins = LoadedPlugins();
  summary.mode = mode;
  summary.seed = plan.plan.seed;
  return summary;
}

// A viewer of a real aircraft only watches.
void BeginLive(Live& live, const LoadedPlan& plan, const std::string& mode) {
  const std::string watches = "this is a flight that is only watched: no viewer commands an aircraft";
  LiveFlight flight;
  flight.subject = FlownSubject(plan, mode);
  flight.telemetry = TelemetryOf(plan);
  flight.messages = MessageOptionsOf(plan.parts);
  flight.messages->truth = false;
  flight.refusals = {.pace = watches, .change = watches};
  live.Begin(std::move(flight));
}

}  // namespace

void RecordNotFlown(const LoadedPlan& plan, const FlyOptions& o, const std::string& why) {
  FlyOptions options = o;
  options.video = options.images = false;
  const std::string mode = records::LiveMode(false, o.dry_run);
  records::Summary summary = SummaryOf(plan, mode);
  summary.outcome = "not flown: " + why;
  summary.complete = true;
  Records(*o.folder, plan, options, mode, MonotonicNow_s()).Finish(summary);
}

void CheckDeclared(const mission::Mission& mission, const std::string& name, Mistakes& mistakes) {
  if (mission.Target() != mission::TargetNeed::kUndeclared) return;
  mistakes.Add(
      "scenario", "mission",
      fmt::format("'{}' does not declare whether it needs its target in sight, so nobody would notice that "
                  "it lost it; valid on a real aircraft: a mission that overrides Mission::Target",
                  name));
}

FlyReport FlyAircraft(const LoadedPlan& plan, vision::LiveCamera& camera, control::AutopilotLink& link,
                      const FlyOptions& o) {
  FlyReport report;
  const std::string mode = records::LiveMode(link.Health().simulated, o.dry_run);
  records::Summary summary = SummaryOf(plan, mode);
  const std::unique_ptr<mission::Mission> mission = plan.plan.flight->Make(plan.parts);
  const double begun_s = MonotonicNow_s();
  std::optional<Records> records;
  if (o.folder) records.emplace(*o.folder, plan, o, mode, begun_s);
  if (o.live) {
    BeginLive(*o.live, plan, mode);
    if (records)
      records->Tell([live = o.live](double t_s, std::string_view what, std::string_view is) {
        live->Event(t_s, what, is);
      });
  }
  BackgroundWriter writer;

  const std::int64_t overwritten_before = camera.Health().overwritten;
  double seen_s = begun_s;
  std::vector<double> reaction_s, vision_s, control_s;
  control::SafetyChange safety;
  const Eigen::Vector3d p_N = link.State().p_NB;
  control::SafeAutopilot safe(link, [&camera] { return camera.Health().age_s; },
                              {.limits = o.limits,
                               .start_N = {p_N.x(), p_N.y(), 0},
                               .dry_run = o.dry_run,
                               .pilot_untold = o.pilot_untold});
  const auto take_changes = [&] {
    const std::vector<control::SafetyChange> changes = safe.TakeChanges();
    if (changes.empty()) return false;
    safety = changes.back();
    if (records) writer.Do([&records, changes, begun_s] { records->Write(changes, begun_s); });
    return true;
  };
  AsHeard autopilot(safe, link);
  ControlMonitor watch;
  LagMonitor lag(mission->MaxLag());
  Losses losses;
  std::string link_error = link.Health().error;  // what the check list said
  const bool needs_target = mission->Target() != mission::TargetNeed::kNone;
  const auto tell = [&](const char* what, const std::string& text) {
    const double t_s = MonotonicNow_s() - begun_s;
    if (records) writer.Do([&records, t_s, what, text] { records->Line(t_s, what, text); });
  };
  const auto note = [&](const control::VehicleState& state) {
    const double t_s = MonotonicNow_s() - begun_s;
    const control::LinkHealth health = link.Health();
    control::SafetyChange known = safety;
    // Of a link that is silent the pilot's switch is unknown too: it was not he.
    if (known.hazard == control::Hazard::kPilot && !health.pilot_allows)
      known.hazard = control::Hazard::kStateLost;
    watch.Note(t_s, known, state);
    if (health.error != link_error) {
      link_error = health.error;
      const std::string is = link_error.empty() ? "in order again" : link_error;
      tell("link", is);
      if (o.told) o.told("link: " + is);
    }
    losses.Note(camera.Health().age_s.value_or(t_s),
                autopilot.heard() ? health.state_age_s.value_or(t_s) : t_s, o.limits);
  };
  mission::Decision last;
  UntilStopped eyes(
      camera, begun_s + o.max_s, o.interrupted,
      [&] {
        const control::VehicleState state = autopilot.State();
        const bool changed = take_changes();
        note(state);
        if (changed && o.progress) o.progress(state, last, safety);
      },
      o.seen);
  const auto record = [&](const vision::Frame& frame, const control::VehicleState& state,
                          const mission::Decision& decision) {
    const double now_s = MonotonicNow_s();
    reaction_s.push_back(now_s - eyes.given_s());
    vision_s.push_back(decision.vision_s);
    control_s.push_back(decision.control_s);
    ++report.frames;
    if (!needs_target || decision.target_state == mission::TargetState::kInSight) seen_s = now_s;
    safe.TargetLostFor(now_s - seen_s);
    if (decision.fix && !o.dry_run && !plan.parts.ground)
      link.See(SightingOf(*decision.fix, frame.t_s, state, plan.parts));
    if (const std::string late = lag.Note(now_s, safe.sent(), state); !late.empty()) {
      tell("autopilot", late);
      if (o.told) o.told("the autopilot " + late);
    }
    take_changes();
    note(state);
    last = decision;
    if (o.progress) o.progress(state, decision, safety);
    if (!records && !o.live) return true;
    records::LogRow row;
    row.sequence = frame.sequence;
    row.exposure.t_s = frame.t_s - begun_s;
    row.now.t_s = now_s - begun_s;
    row.estimate = state;
    row.heard = autopilot.heard();
    row.sent = safe.sent();
    row.hazard = control::NameOf(safety.hazard);
    row.reaction = control::NameOf(safety.reaction);
    row.decision = decision;
    cv::Mat drawn, product;
    const bool shown = o.live && o.live->WantsPicture(Picture::kOnBoard);
    if (o.video || shown) drawn = records::DrawnView(frame, row.now.t_s, *mission, mode);
    if (o.live) {
      o.live->Row(row, o.live->WantsImage() ? frame.image : cv::Mat());
      if (shown) o.live->Show(Picture::kOnBoard, row.now.t_s, drawn);
      o.live->Wait(row.now.t_s, [] { return true; });  // for no one: those who ask are refused
    }
    if (!records) return true;
    if (o.video) {
      product = mission->ProductImage().clone();  // the mission goes on with its own
    }
    writer.Do([&records, row, drawn, product, frame, state, video = o.video] {
      records->Write(row);
      if (video) records->WriteImages(drawn, product);
      records->Record(frame, state, row.decision);
    });
    return true;
  };
  try {
    const std::string outcome = mission::Fly(eyes, autopilot, *mission, record);
    take_changes();
    const ControlMonitor::Verdict verdict = watch.Judge(outcome, eyes.why(), mission->Accomplished());
    if (o.dry_run) {
      report.accomplished = o.checked && !losses.images && !losses.state && report.frames > 0;
      report.outcome = fmt::format("computed, nothing flown: {}{}{}", outcome.empty() ? eyes.why() : outcome,
                                   o.checked ? "" : "; the check list was not met", losses.Text());
    } else {
      report.accomplished = verdict.accomplished;
      report.outcome = verdict.outcome;
    }
  } catch (const std::exception& e) {  // a mistake in flight code
    report.outcome = "broke off";
    report.error = e.what();
  }
  report.lag = lag.told();
  take_changes();
  if (const auto released = safe.LetGo(o.release)) {
    report.release = control::TextOf(released->how, released->after_s);
    tell("release", report.release);
  }
  link.Silence();
  writer.Finish();
  report.images_overwritten = camera.Health().overwritten - overwritten_before;
  report.records_dropped = writer.dropped();
  if (report.error.empty()) report.error = writer.error();
  report.accomplished = report.accomplished && report.error.empty();
  const records::StageTime reaction = records::StageTimeOf(reaction_s);
  report.mean_ms = reaction.mean_ms;
  report.p99_ms = reaction.p99_ms;
  if (!records && !o.live) return report;
  summary.outcome = report.outcome;
  summary.error = report.error;
  summary.complete = report.error.empty();
  summary.passed = report.accomplished;
  summary.sim_s = summary.wall_s = MonotonicNow_s() - begun_s;
  summary.stages = {{"vision", records::StageTimeOf(vision_s)},
                    {"control", records::StageTimeOf(control_s)},
                    {"image_to_setpoint", reaction}};
  const auto fail = [&](const std::exception& e) {
    if (report.error.empty()) report.error = summary.error = e.what();
    report.accomplished = summary.complete = summary.passed = false;
  };
  if (records) {
    try {
      mission->WriteProducts(*o.folder);
    } catch (const std::exception& e) {
      fail(e);
    }
    try {
      records->Finish(summary);
    } catch (const std::exception& e) {
      fail(e);
    }
  }
  if (o.live) o.live->End(summary);
  return report;
}

}  // namespace kestrel::flight
