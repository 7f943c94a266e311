// SPDX-License-Identifier: Apache-2.0
#include "scenarios/event_log.h"

#include <spdlog/sinks/basic_file_sink.h>

namespace kestrel {

EventLog::EventLog(const std::filesystem::path& folder) {
  auto sink = std::make_shared<spdlog::sinks::basic_file_sink_st>((folder / "events.log").string(), true);
  log_ = std::make_shared<spdlog::logger>("events", std::move(sink));
  log_->set_pattern("%v");  // the time that counts is that of the flight: the same run gives the same file
}

EventLog::~EventLog() { log_->flush(); }

void EventLog::Write(const LogRow& row) {
  const double t = row.now.t_s;
  const auto changed = [&](std::string& was, std::string_view is, const char* what) {
    if (was == is) return;
    log_->info("{:9.3f} s  {}: {}", t, what, is);
    was = is;
  };
  changed(phase_, row.decision.phase, "phase");
  changed(target_, row.decision.target, "target");
  changed(mode_, NameOf(row.estimate.mode), "autopilot");
  if (row.estimate.saturated != saturated_) {
    saturated_ = row.estimate.saturated;
    log_->info("{:9.3f} s  autopilot: {}", t, saturated_ ? "saturated" : "no longer saturated");
  }
  if (row.now.touching != touching_) {
    touching_ = row.now.touching;
    log_->info("{:9.3f} s  truth: {}", t, touching_ ? "skids touch" : "skids clear");
  }
}

void EventLog::End(double t_s, const std::string& how) { log_->info("{:9.3f} s  end: {}", t_s, how); }

}  // namespace kestrel
