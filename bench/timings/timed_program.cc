// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timed_program.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "base/diagnostics.h"

namespace kestrel::bench {
namespace {

constexpr std::size_t kLongestLine = 1 << 16;

}  // namespace

TimedProgram::TimedProgram(const std::filesystem::path& program)
    : program_(program),
      process_({program.string(), "bench", "timings", "--in-turn"}, PipedProcess::Direction::kBoth) {
  const std::optional<std::string> line = process_.ReadLine(kLongestLine);
  try {
    const auto greeting = nlohmann::json::parse(line.value_or(""));
    if (greeting.at("kestrel_timings") != 1) throw std::invalid_argument("of another kind");
    version_ = greeting.at("version").get<std::string>();
    machine_ = greeting.at("machine").get<TimingMachine>();
    work_ = greeting.at("work").get<std::vector<std::string>>();
  } catch (const std::exception&) {
    throw InputError(program_.string(), "the program does not answer `bench timings --in-turn`",
                     "valid: a program kestrel that has `bench timings`");
  }
}

WorkTimes TimedProgram::Time(const std::string& work) {
  process_.Write(work + "\n");
  const std::optional<std::string> line = process_.ReadLine(kLongestLine);
  if (!line) {
    process_.Close();  // says how the program ended
    throw std::runtime_error(fmt::format("{} ended while it was timing '{}'", program_.string(), work));
  }
  if (line->starts_with("! "))
    throw std::runtime_error(fmt::format("{}: {}: {}", program_.string(), work, line->substr(2)));
  WorkTimes times;
  std::istringstream text(*line);
  text >> times.processor_ms >> times.wall_ms >> times.pieces;
  if (!text || !(times.processor_ms > 0) || !(times.wall_ms > 0) || !(times.pieces > 0))
    throw std::runtime_error(fmt::format("{}: {}: no times: '{}'", program_.string(), work, *line));
  return times;
}

}  // namespace kestrel::bench
