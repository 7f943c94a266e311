// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/worker_wire.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace kestrel::campaign {
namespace {

using nlohmann::json;

// JSON has no words for numbers that are not finite.
json ToJson(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

double NumberOf(const json& value) {
  if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (value == "inf") return std::numeric_limits<double>::infinity();
  if (value == "-inf") return -std::numeric_limits<double>::infinity();
  return value.get<double>();
}

// What a program said need not be UTF-8.
std::string Line(const json& all) { return all.dump(-1, ' ', false, json::error_handler_t::replace) + "\n"; }

template <class Read>
auto Parsed(const std::string& line, const Read& read) {
  try {
    return read(json::parse(line));
  } catch (const json::exception& e) {
    throw std::runtime_error(
        fmt::format("'{}' is none of the wire's lines: {}", line.substr(0, 200), e.what()));
  }
}

}  // namespace

std::string OrderLine(const RunOrder& order) {
  json all = {{"row", order.row},
              {"scenario", order.scenario},
              {"overrides", order.overrides},
              {"video", order.video}};
  if (order.folder) all["folder"] = order.folder->string();
  return Line(all);
}

RunOrder OrderOf(const std::string& line) {
  return Parsed(line, [](const json& all) {
    RunOrder order{all.at("row"), all.at("scenario"), all.at("overrides"), std::nullopt, all.at("video")};
    if (all.contains("folder")) order.folder = all.at("folder").get<std::string>();
    return order;
  });
}

std::string ReportLine(const RunResult& r) {
  json metrics = json::object();
  for (const auto& [name, value] : r.metrics) metrics[name] = ToJson(value);
  return Line({{"row", r.row},
               {"status", NameOf(r.status)},
               {"outcome", r.outcome},
               {"metrics", metrics},
               {"state_hash", r.state_hash},
               {"image_hash", r.image_hash},
               {"flight_s", r.execution.wall_s},
               {"peak_mib", r.execution.peak_mib}});
}

RunResult ReportOf(const std::string& line) {
  return Parsed(line, [](const json& all) {
    RunResult r;
    r.row = all.at("row");
    r.status = RunStatusOf(all.at("status").get<std::string>());
    r.outcome = all.at("outcome");
    for (const auto& [name, value] : all.at("metrics").items()) r.metrics[name] = NumberOf(value);
    r.state_hash = all.at("state_hash"), r.image_hash = all.at("image_hash");
    r.execution.wall_s = all.at("flight_s"), r.execution.peak_mib = all.at("peak_mib");
    return r;
  });
}

bool IsGreeting(const std::string& line) {
  const json all = json::parse(line, nullptr, false);
  return all.is_object() && all.value("ready", false);
}

}  // namespace kestrel::campaign
