// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timing_record.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/user_file.h"

namespace kestrel::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKind = "kestrel timings";
constexpr const char* kRemedy = "valid: what `kestrel bench timings --json FILE` wrote, or a program kestrel";

const std::vector<std::string> kColumns = {
    "processor_ms",        "wall_ms",       "pieces", "arithmetic_processor_ms", "arithmetic_wall_ms",
    "memory_processor_ms", "memory_wall_ms"};

std::array<double*, 7> Fields(CalibratedBlock& b) {
  return {&b.work.processor_ms,  &b.work.wall_ms,        &b.work.pieces,   &b.arithmetic.processor_ms,
          &b.arithmetic.wall_ms, &b.memory.processor_ms, &b.memory.wall_ms};
}

TimingRecord Parsed(const std::string& text) {
  const Json json = Json::parse(text);
  if (!json.is_object() || json.value("kind", "") != kKind || json.value("format", 0) != 1)
    throw std::invalid_argument("is no run of `bench timings` of this format");
  if (json.at("columns") != kColumns) throw std::invalid_argument("has other columns");
  TimingRecord record{json.at("version"), json.at("machine"), {}};
  for (const Json& each : json.at("rounds")) {
    TimingRound round;
    for (const auto& [name, blocks] : each.items())
      for (const Json& row : blocks) {
        CalibratedBlock block;
        const auto fields = Fields(block);
        if (row.size() != fields.size())
          throw std::invalid_argument("has a block of '" + name + "' that is not whole");
        for (std::size_t i = 0; i < fields.size(); ++i) {
          *fields[i] = row.at(i).get<double>();
          if (!(*fields[i] > 0) || !std::isfinite(*fields[i]))
            throw std::invalid_argument("has a time of '" + name + "' that is not above 0");
        }
        round[name].push_back(block);
      }
    for (const auto& [name, blocks] : record.rounds.empty() ? round : record.rounds.front())
      if (!round.contains(name)) throw std::invalid_argument("has a round without '" + name + "'");
    if (round.empty()) throw std::invalid_argument("has a round of nothing");
    record.rounds.push_back(std::move(round));
  }
  if (record.rounds.size() < 2) throw std::invalid_argument("has fewer than two rounds");
  return record;
}

}  // namespace

std::string ToJson(const TimingRecord& record) {
  Json json = {{"kind", kKind},
               {"format", 1},
               {"version", record.version},
               {"machine", record.machine},
               {"columns", kColumns},
               {"rounds", Json::array()}};
  for (const TimingRound& round : record.rounds) {
    Json of_round = Json::object();
    for (const auto& [name, blocks] : round)
      for (CalibratedBlock block : blocks) {
        Json row = Json::array();
        for (const double* field : Fields(block)) row.push_back(*field);
        of_round[name].push_back(row);
      }
    json["rounds"].push_back(of_round);
  }
  return json.dump() + "\n";
}

TimingRecord ReadTimingRecord(const std::filesystem::path& file, Mistakes& mistakes) {
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) {
    mistakes.Add(file.string(), "", content.error, kRemedy);
    return {};
  }
  try {
    return Parsed(content.bytes);
  } catch (const Json::parse_error&) {
    mistakes.Add(file.string(), "", "is no JSON", kRemedy);
  } catch (const std::exception& e) {
    // A library's sentence, of a key that is missing or of another type, tells a user nothing.
    const bool ours = dynamic_cast<const std::invalid_argument*>(&e) != nullptr;
    mistakes.Add(file.string(), "", ours ? e.what() : "lacks a part, or has one of another type", kRemedy);
  }
  return {};
}

}  // namespace kestrel::bench
