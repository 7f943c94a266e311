// SPDX-License-Identifier: Apache-2.0
#include "records/page/flight_data.h"

#include <fmt/format.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/diagnostics.h"
#include "base/file/files.h"
#include "base/user_file.h"
#include "records/page/flight_json.h"
#include "records/page/page_media.h"
#include "records/page/telemetry_columns.h"
#include "records/summary.h"

namespace kestrel::records {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// A file of a run that ended, or what there is of one that did not; empty: none.
fs::path WholeOrPart(const fs::path& file) {
  for (const fs::path& each : {file, PartOf(file)})
    if (IsFile(each)) return each;
  return {};
}

std::string TextOf(const fs::path& file) {
  FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) throw InputError(file.string(), content.error);
  return std::move(content.bytes);
}

// Lines "   12.345 s  what: is". A text may go over several lines: what is no beginning of one belongs to the last.
Json EventsOf(std::string_view log) {
  constexpr std::string_view kUnit = " s  ";
  Json events = Json::array();
  while (!log.empty()) {
    const std::size_t end = log.find('\n');
    if (end == std::string_view::npos) break;  // cut off
    const std::string line(log.substr(0, end));
    log.remove_prefix(end + 1);
    char* rest = nullptr;
    const double t_s = std::strtod(line.c_str(), &rest);
    const std::string_view after(rest);
    const std::size_t colon = after.find(": ");
    if (rest != line.c_str() && after.starts_with(kUnit) && colon != std::string_view::npos)
      events.push_back({{"t_s", t_s},
                        {"what", after.substr(kUnit.size(), colon - kUnit.size())},
                        {"is", after.substr(colon + 2)}});
    else if (!events.empty())
      events.back()["is"] = events.back()["is"].get<std::string>() + '\n' + line;
  }
  return events;
}

Summary SummaryOf(const fs::path& folder, const FlightSubject& subject) {
  if (IsFile(folder / "summary.json")) return ReadSummary(folder / "summary.json");
  Summary summary;
  summary.scenario = subject.scenario;
  summary.seed = subject.seed;
  summary.mode = subject.mode;
  summary.version = subject.version;
  summary.outcome = "broke off";
  summary.error = "the flight did not end in good order: it has no summary.json";
  return summary;
}

// Of a folder without page.json.
FlightSubject SubjectOf(const Summary& summary) {
  FlightSubject subject;
  subject.scenario = summary.scenario;
  subject.seed = summary.seed;
  subject.mode = summary.mode;
  subject.version = summary.version;
  subject.title = summary.scenario;
  return subject;
}

}  // namespace

std::string FlightData(const fs::path& folder) {
  const bool told = IsFile(folder / "page.json");
  if (!told && !IsFile(folder / "summary.json"))
    throw InputError(folder.string(), "holds neither summary.json nor page.json: it is no folder of a flight",
                     "valid: what `kestrel run`, `serve` or `fly` has written");
  try {
    FlightSubject subject;
    if (told) subject = ReadSubject(folder);
    const Summary summary = SummaryOf(folder, subject);
    if (!told) subject = SubjectOf(summary);
    TelemetryColumnsJson columns{"{}"};
    if (const fs::path csv = WholeOrPart(folder / "telemetry.csv"); !csv.empty()) {
      try {
        columns = ColumnsOf(TextOf(csv));
      } catch (const std::runtime_error& e) {
        throw InputError(csv.string(), e.what());
      }
    }
    if (subject.rate_hz <= 0) subject.rate_hz = columns.rate_hz;
    Json flight = SubjectJson(subject);
    flight.update(OutcomeJson(summary));
    const fs::path log = WholeOrPart(folder / "events.log");
    flight["events"] = log.empty() ? Json::array() : EventsOf(TextOf(log));
    flight["live"] = false;
    flight["left_out"] = LeftOutOfPage(folder);
    std::string json = flight.dump(-1, ' ', false, Json::error_handler_t::replace);
    json.pop_back();
    return json + ",\"columns\":" + columns.json + '}';
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& e) {
    throw InputError("report", e.what());
  }
}

}  // namespace kestrel::records
