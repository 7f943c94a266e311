// SPDX-License-Identifier: Apache-2.0
#include "records/summary.h"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

namespace kestrel::records {
namespace {

using Json = nlohmann::ordered_json;  // its dump writes numbers that are not finite as null

double Number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

std::uint64_t Hash(const Json& json) {
  const auto text = json.get<std::string>();
  std::uint64_t hash = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
  if (text.size() != 16 || error != std::errc() || end != text.data() + text.size()) {
    throw std::runtime_error(fmt::format("'{}' is not a hash of 16 hexadecimal digits", text));
  }
  return hash;
}

}  // namespace

std::string ToJson(const Summary& s) {
  Json criteria = Json::array(), metrics = Json::object(), stages = Json::object(), drawn = Json::object(),
       machine = Json::object();
  for (const Criterion& c : s.criteria) {
    criteria.push_back({{"name", c.name},
                        {"value", c.value},
                        {"limit", c.limit},
                        {"at_least", c.at_least},
                        {"passed", c.passed}});
  }
  for (const auto& [name, value] : s.metrics) metrics[name] = value;
  for (const auto& [key, value] : s.drawn) drawn[key] = value;
  for (const auto& [name, value] : s.machine) machine[name] = value;
  for (const auto& [name, time] : s.stages)
    stages[name] = {{"mean_ms", time.mean_ms}, {"p99_ms", time.p99_ms}};
  const Json json = {{"scenario", s.scenario},
                     {"seed", s.seed},
                     {"mode", s.mode},
                     {"version", s.version},
                     {"plugins", s.plugins},
                     {"complete", s.complete},
                     {"passed", s.passed},
                     {"outcome", s.outcome},
                     {"error", s.error},
                     {"criteria", criteria},
                     {"metrics", metrics},
                     {"drawn", drawn},
                     {"timing",
                      {{"sim_s", s.sim_s},
                       {"wall_s", s.wall_s},
                       {"real_time_factor", s.wall_s > 0 ? s.sim_s / s.wall_s : 0},
                       {"stages", stages}}},
                     {"state_hash", fmt::format("{:016x}", s.state_hash)},
                     {"image_hash", fmt::format("{:016x}", s.image_hash)},
                     {"renderer", s.renderer},
                     {"machine", machine}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

Summary SummaryFromJson(const std::string& text, const std::string& name) {
  try {
    const Json json = Json::parse(text);
    Summary s;
    s.scenario = json.at("scenario");
    s.seed = json.at("seed");
    s.mode = json.at("mode");
    s.version = json.at("version");
    s.complete = json.at("complete");
    s.passed = json.at("passed");
    s.outcome = json.at("outcome");
    s.error = json.at("error");
    for (const Json& c : json.at("criteria")) {
      s.criteria.push_back(
          {c.at("name"), Number(c.at("value")), Number(c.at("limit")), c.at("at_least"), c.at("passed")});
    }
    for (const auto& [key, value] : json.at("metrics").items()) s.metrics[key] = Number(value);
    for (const auto& [key, value] : json.at("drawn").items()) s.drawn[key] = Number(value);
    const Json& timing = json.at("timing");
    s.sim_s = Number(timing.at("sim_s"));
    s.wall_s = Number(timing.at("wall_s"));
    for (const auto& [key, time] : timing.at("stages").items()) {
      s.stages[key] = {Number(time.at("mean_ms")), Number(time.at("p99_ms"))};
    }
    s.state_hash = Hash(json.at("state_hash"));
    s.image_hash = Hash(json.at("image_hash"));
    s.renderer = json.at("renderer");
    if (json.contains("plugins")) s.plugins = json.at("plugins");
    if (json.contains("machine")) s.machine = json.at("machine");  // which older ones do not say
    return s;
  } catch (const std::exception& e) {
    throw std::runtime_error(fmt::format("{}: not a summary: {}", name, e.what()));
  }
}

Summary ReadSummary(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(fmt::format("cannot read {}: {}", file.string(), std::strerror(errno)));
  std::ostringstream text;
  text << in.rdbuf();
  return SummaryFromJson(text.str(), file.string());
}

StageTime StageTimeOf(std::vector<double> seconds) {
  if (seconds.empty()) return {};
  double sum = 0;
  for (const double s : seconds) sum += s;
  const std::size_t rank =
      static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(seconds.size()))) - 1;
  std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(rank), seconds.end());
  return {1e3 * sum / static_cast<double>(seconds.size()), 1e3 * seconds[rank]};
}

}  // namespace kestrel::records
