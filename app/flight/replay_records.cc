// SPDX-License-Identifier: Apache-2.0
#include "app/flight/replay_records.h"

#include <stdexcept>
#include <utility>

#include "app/page/report_command.h"
#include "base/file/files.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "flight/flight_subject.h"
#include "flight/load_plugins.h"
#include "records/telemetry/flight_mode.h"
#include "records/video/drawn_view.h"

namespace kestrel::app {
namespace {

records::TelemetryOptions TelemetryOf(const flight::FlightPlan& plan) {
  return {.truth = false, .mission = &plan.flight.type()};
}

records::RecorderOptions OptionsFor(const flight::FlightPlan& plan, double rate_hz) {
  records::RecorderOptions options;
  options.rate_hz = rate_hz;
  options.plots.title = std::string(records::kRecordingMode) + ", " + plan.name;
  options.telemetry = TelemetryOf(plan);
  return options;
}

records::FlightSubject SubjectOf(const flight::LoadedPlan& plan, double rate_hz) {
  records::FlightSubject subject =
      flight::SubjectOf(plan.plan, plan.parts, records::kRecordingMode, plan.description);
  subject.rate_hz = rate_hz;
  return subject;
}

}  // namespace

ReplayRecords::Folder::Folder(const std::filesystem::path& folder, const flight::LoadedPlan& plan,
                              double rate_hz)
    : where(folder), lock(LockFolder(folder)), recorder(folder, OptionsFor(plan.plan, rate_hz)) {
  WriteFile(folder / "scenario.yaml", ToYaml(plan.plan));
  records::WriteSubject(folder, SubjectOf(plan, rate_hz));
}

ReplayRecords::ReplayRecords(const std::optional<std::filesystem::path>& folder, flight::Live* live,
                             const flight::LoadedPlan& plan, double rate_hz)
    : live_(live), plan_(plan) {
  if (folder) {
    folder_.emplace(*folder, plan, rate_hz);
    events_.emplace(*folder);
  } else {
    events_.emplace();
  }
  if (live_) BeginLive(rate_hz);
  events_->Line(0, "mode", records::kRecordingMode);
}

void ReplayRecords::BeginLive(double rate_hz) {
  flight::LiveFlight flight;
  flight.subject = SubjectOf(plan_, rate_hz);
  flight.telemetry = TelemetryOf(plan_.plan);
  flight.messages = flight::MessageOptionsOf(plan_.parts);
  flight.messages->truth = false;
  flight.refusals.change = "it is a recording: what was flown cannot be changed";
  live_->Begin(std::move(flight));
  events_->Tell(
      [this](double t_s, std::string_view what, std::string_view is) { live_->Event(t_s, what, is); });
}

void ReplayRecords::Write(const vision::Frame& frame, const control::VehicleState& state,
                          const mission::Decision& decision, const mission::Mission& mission) {
  if (!first_s_) first_s_ = frame.t_s;
  last_s_ = frame.t_s - *first_s_;
  records::LogRow row;
  row.sequence = frame.sequence;
  row.exposure.t_s = row.now.t_s = last_s_;
  row.estimate = state;
  row.decision = decision;
  const bool shown = live_ && live_->WantsPicture(flight::Picture::kOnBoard);
  cv::Mat drawn;
  if (folder_ || shown) drawn = records::DrawnView(frame, last_s_, mission, records::kRecordingMode);
  if (folder_) {
    folder_->recorder.Write(row);
    folder_->recorder.WriteImage(drawn);
  }
  events_->Write(row);
  if (!live_) return;
  live_->Row(row, live_->WantsImage() ? frame.image : cv::Mat());
  if (shown) live_->Show(flight::Picture::kOnBoard, last_s_, drawn);
  live_->Wait(last_s_, [] { return true; });
}

std::string ReplayRecords::Finish(const std::string& outcome, bool passed, double wall_s) {
  records::Summary summary;
  summary.scenario = plan_.plan.name;
  summary.version = Version();
  summary.plugins = flight::LoadedPlugins();
  summary.mode = records::kRecordingMode;
  summary.seed = plan_.plan.seed;
  summary.outcome = outcome;
  summary.complete = true;
  summary.passed = passed;
  summary.sim_s = last_s_;
  summary.wall_s = wall_s;
  events_->End(last_s_, summary.outcome);
  if (folder_) summary = folder_->recorder.Finish(summary);
  if (live_) live_->End(summary);
  if (!summary.error.empty()) throw std::runtime_error(summary.error);
  return folder_ ? ReportOf(folder_->where) : "";
}

}  // namespace kestrel::app
