// SPDX-License-Identifier: Apache-2.0
#include "campaign/report/page_data.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/html/html.h"
#include "base/user_file.h"
#include "campaign/report/trajectory.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxTrajectories = 60, kPointsOfTrajectory = 250;

// From its folder: a page and its recordings may be moved together. As a link has it; empty: outside that
// folder, where a page that somebody was sent is not to lead. The ./ before it keeps a name from being a
// scheme.
std::string LinkTo(const fs::path& file, const fs::path& page_folder) {
  const fs::path inside = fs::proximate(file, page_folder.empty() ? "." : page_folder);
  if (inside.is_absolute() || inside.empty() || *inside.begin() == "..") return {};
  std::string link = "./";
  for (const char c : inside.generic_string()) {
    constexpr std::string_view kReserved = "%?#\"<> ";
    if (kReserved.find(c) == std::string_view::npos) {
      link += c;
    } else {
      constexpr char kDigits[] = "0123456789ABCDEF";
      const auto byte = static_cast<unsigned char>(c);
      link += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return link;
}

// Of a run's records: where they were written, or where they lie beside results that were moved. None: they
// are no more.
fs::path RecordingOf(const ReportSubject& subject, const RunResult& run) {
  if (run.execution.recording.empty()) return {};
  const fs::path written = run.execution.recording;
  const fs::path moved = fs::path(subject.results_file).parent_path() / "recordings" / written.filename();
  std::error_code none;
  for (const fs::path& folder : {written, moved})
    if (fs::is_directory(folder, none)) return folder;
  return {};
}

Json RunOf(const ReportSubject& subject, const RunResult& run, const std::vector<std::string>& metrics,
           const fs::path& page_folder) {
  Json values = Json::array();
  for (const std::string& name : metrics) {
    const auto found = run.metrics.find(name);
    values.push_back(found == run.metrics.end() ? Json() : Json(found->second));
  }
  Json json = {{"row", run.row},
               {"status", NameOf(run.status)},
               {"outcome", run.outcome},
               {"values", subject.identity.table.rows.at(static_cast<std::size_t>(run.row))},
               {"metrics", values},
               {"state_hash", run.state_hash},
               {"image_hash", run.image_hash}};
  if (run.status != RunStatus::kPassed && !run.execution.log.empty()) json["log"] = run.execution.log;
  if (const fs::path recording = RecordingOf(subject, run); !recording.empty()) {
    if (const std::string link = LinkTo(recording, page_folder); !link.empty()) {
      json["recording"] = link;
      if (IsFile(recording / "video.mp4")) json["video"] = LinkTo(recording / "video.mp4", page_folder);
    }
  }
  return json;
}

// The thickness of a line on the page is some millimetres.
Json Rounded(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(std::round(value * 1e3) / 1e3);
  return json;
}

Json TrajectoriesOf(const ReportSubject& subject) {
  Json all = Json::array();
  for (const bool passed : {false, true}) {
    for (const RunResult& run : subject.results) {
      const fs::path recording = RecordingOf(subject, run);
      if ((run.status == RunStatus::kPassed) != passed || recording.empty()) continue;
      if (all.size() == kMaxTrajectories) return all;
      if (const auto t = ReadTrajectory(recording / "telemetry.csv", kPointsOfTrajectory))
        all.push_back({{"row", run.row},
                       {"t_s", Rounded(t->t_s)},
                       {"north_m", Rounded(t->north_m)},
                       {"east_m", Rounded(t->east_m)},
                       {"height_m", Rounded(t->height_m)}});
    }
  }
  return all;
}

// "criteria.touchdown_error_m.max": 0.12
Json LimitsOf(const std::map<std::string, std::string>& scenario) {
  constexpr std::string_view kCriteria = "criteria.";
  Json limits = Json::object();
  for (const auto& [key, text] : scenario) {
    const std::size_t dot = key.rfind('.');
    if (!key.starts_with(kCriteria) || dot < kCriteria.size()) continue;
    if (const auto value = NumberIn(text))
      limits[key.substr(kCriteria.size(), dot - kCriteria.size())][key.substr(dot + 1)] = *value;
  }
  return limits;
}

Json TuningOf(const std::optional<TuningHistory>& tuning) {
  if (!tuning) return {};
  Json json = {{"cost", tuning->cost},
               {"start_cost", tuning->start_cost ? Json(*tuning->start_cost) : Json()},
               {"verdict", tuning->verdict},
               {"searches", Json::array()},
               {"gains", Json::array()}};
  for (const SearchCurve& s : tuning->searches)
    json["searches"].push_back({{"method", s.method},
                                {"repetition", s.repetition},
                                {"flights", s.flights},
                                {"cost", s.cost},
                                {"held_out", s.held_out ? Json(*s.held_out) : Json()}});
  for (const TunedGain& g : tuning->gains)
    json["gains"].push_back({{"key", g.key},
                             {"start", g.start},
                             {"tuned", g.tuned},
                             {"low", g.low},
                             {"high", g.high},
                             {"log", g.log}});
  return json;
}

}  // namespace

std::string PageData(const ReportSubject& subject, const fs::path& page_folder) {
  const auto plan = ValuesOf(subject.identity.plan, "plan");
  const auto scenario = ValuesOf(subject.identity.scenario, "scenario");
  const auto name = plan.find("scenario");
  std::vector<std::string> metrics;
  for (const MetricSummary& metric : subject.summary.metrics) metrics.push_back(metric.name);
  Json runs = Json::array();
  for (const RunResult& run : subject.results) runs.push_back(RunOf(subject, run, metrics, page_folder));
  const Json data = {{"name", subject.summary.name},
                     {"version", subject.summary.version},
                     {"table_hash", subject.summary.table_hash},
                     {"scenario", name == plan.end() ? "" : name->second},
                     {"results_file", subject.results_file},
                     {"replay", subject.replay},
                     {"run", subject.run},
                     {"again", subject.again},
                     {"summary", Json::parse(ToJson(subject.summary))},
                     {"limits", LimitsOf(scenario)},
                     {"keys", subject.identity.table.keys},
                     {"metrics", metrics},
                     {"runs", runs},
                     {"trajectories", TrajectoriesOf(subject)},
                     {"tuning", TuningOf(subject.tuning)},
                     {"plan_text", subject.identity.plan},
                     {"scenario_text", subject.identity.scenario}};
  return InScript(data.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace kestrel::campaign
