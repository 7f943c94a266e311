// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timing_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <istream>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "base/version.h"
#include "bench/timings/timed_work.h"
#include "bench/timings/timing_machine.h"

namespace kestrel::bench {

void ServeTimings(std::istream& in, std::ostream& out) {
  nlohmann::ordered_json greeting = {
      {"kestrel_timings", 1}, {"version", Version()}, {"machine", ThisTimingMachine()}};
  for (const TimedWork& work : AllTimedWork()) greeting["work"].push_back(work.name);
  out << greeting.dump() << std::endl;
  std::map<std::string, Block> ready;
  for (std::string name; std::getline(in, name);) {
    std::string answer;
    try {
      if (!ready.contains(name)) ready[name] = PrepareWork(name);
      const WorkTimes times = ready[name]();
      answer = fmt::format("{} {} {}", times.processor_ms, times.wall_ms, times.pieces);
    } catch (const std::exception& e) {
      answer = fmt::format("! {}", e.what());
      std::replace(answer.begin(), answer.end(), '\n', ' ');
    }
    out << answer << std::endl;
  }
}

}  // namespace kestrel::bench
