// SPDX-License-Identifier: Apache-2.0
#include "app/flight/replay_records.h"

#include <stdexcept>

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

records::RecorderOptions OptionsFor(const flight::FlightPlan& plan, double rate_hz) {
  records::RecorderOptions options;
  options.rate_hz = rate_hz;
  options.plots.title = std::string(records::kRecordingMode) + ", " + plan.name;
  options.telemetry = {.truth = false, .mission = &plan.flight.type()};
  return options;
}

}  // namespace

ReplayRecords::ReplayRecords(const std::filesystem::path& folder, const flight::LoadedPlan& plan,
                             double rate_hz)
    : folder_(folder),
      lock_(LockFolder(folder)),
      plan_(plan),
      recorder_(folder, OptionsFor(plan.plan, rate_hz)),
      events_(folder) {
  WriteFile(folder / "scenario.yaml", ToYaml(plan.plan));
  records::FlightSubject subject =
      flight::SubjectOf(plan.plan, plan.parts, records::kRecordingMode, plan.description);
  subject.rate_hz = rate_hz;
  records::WriteSubject(folder, subject);
  events_.Line(0, "mode", records::kRecordingMode);
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
  recorder_.Write(row);
  events_.Write(row);
  recorder_.WriteImage(records::DrawnView(frame, last_s_, mission, records::kRecordingMode));
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
  events_.End(last_s_, summary.outcome);
  summary = recorder_.Finish(summary);
  if (!summary.error.empty()) throw std::runtime_error(summary.error);
  return ReportOf(folder_);
}

}  // namespace kestrel::app
