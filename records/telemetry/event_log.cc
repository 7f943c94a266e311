// SPDX-License-Identifier: Apache-2.0
#include "records/telemetry/event_log.h"

#include <fmt/format.h>

namespace kestrel::records {

void EventLog::Line(double t_s, std::string_view what, std::string_view is) {
  for (const auto& listener : listeners_) listener(t_s, what, is);
  if (!file_) return;
  file_->Write(fmt::format("{:9.3f} s  {}: {}\n", t_s, what, is));
  file_->Flush();
}

void EventLog::Write(const LogRow& row) {
  const double t = row.now.t_s;
  const auto changed = [&](std::string& was, std::string_view is, const char* what) {
    if (was == is) return;
    Line(t, what, is);
    was = is;
  };
  changed(phase_, row.decision.phase, "phase");
  changed(target_, row.decision.target, "target");
  changed(mode_, row.heard ? control::NameOf(row.estimate.mode) : "its state is not heard", "autopilot");
  if (row.estimate.saturated != saturated_) {
    saturated_ = row.estimate.saturated;
    Line(t, "autopilot", saturated_ ? "saturated" : "no longer saturated");
  }
  if (row.estimate.aided != aided_) {
    aided_ = row.estimate.aided;
    Line(t, "autopilot", aided_ ? "flies by an attitude from outside" : "flies by its own attitude");
  }
  if (row.now.attitude_failed != attitude_failed_) {
    attitude_failed_ = row.now.attitude_failed;
    Line(t, "truth", attitude_failed_ ? "the autopilot's own attitude fails" : "it is back");
  }
  if (row.now.touching != touching_) {
    touching_ = row.now.touching;
    Line(t, "truth", touching_ ? "skids touch" : "skids clear");
  }
}

void EventLog::WriteCamera(double t_s, std::string_view condition) {
  if (condition == camera_) return;
  Line(t_s, "camera", condition);
  camera_ = condition;
}

void EventLog::End(double t_s, std::string_view how) {
  Line(t_s, "end", how);
  if (file_) file_->Close();
}

}  // namespace kestrel::records
