// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timed_program.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "base/diagnostics.h"
#include "base/stopwatch.h"

namespace kestrel::bench {
namespace {

constexpr std::size_t kLongestLine = 1 << 16;
constexpr double kBlock_s = 600;  // far more than any takes on a machine that is busy with much else

InputError NoSuchProgram(const std::filesystem::path& program) {
  return {program.string(), "the program does not answer `bench timings --in-turn`",
          "valid: a program kestrel that has `bench timings`"};
}

PipedProcess Begin(const std::filesystem::path& program) try {
  return PipedProcess({program.string(), "bench", "timings", "--in-turn"}, PipedProcess::Direction::kBoth);
} catch (const std::runtime_error&) {  // as of a text that may be run
  throw NoSuchProgram(program);
}

}  // namespace

TimedProgram::TimedProgram(const std::filesystem::path& program, double patience_s)
    : program_(program), process_(Begin(program)) {
  const std::optional<std::string> line = process_.ReadLine(kLongestLine, patience_s);
  try {
    const auto greeting = nlohmann::json::parse(line.value_or(""));
    if (greeting.at("kestrel_timings") != 1) throw std::invalid_argument("of another kind");
    version_ = greeting.at("version").get<std::string>();
    machine_ = greeting.at("machine").get<TimingMachine>();
    work_ = greeting.at("work").get<std::vector<std::string>>();
  } catch (const std::exception&) {
    process_.Kill();
    throw NoSuchProgram(program_);
  }
}

WorkTimes TimedProgram::Time(const std::string& work) {
  process_.Write(work + "\n");
  const double start_s = MonotonicNow_s();
  const std::optional<std::string> line = process_.ReadLine(kLongestLine, kBlock_s);
  if (!line) {
    if (MonotonicNow_s() - start_s > kBlock_s) {
      process_.Kill();
      throw std::runtime_error(fmt::format("{} did not answer within {:g} s when it was timing '{}'",
                                           program_.string(), kBlock_s, work));
    }
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
