// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "flight/simulated/flight_records.h"
#include "flight/stepped/sim.h"

namespace kestrel::flight {

// The folder of a flight that is flown step by step, as that of a run: from its Reset() to its end.
class RecordedFlight {
 public:
  // After the Reset() that gave this. Throws as FlightRecords.
  RecordedFlight(const Sim& sim, const Observation& first, const std::filesystem::path& folder, bool video);

  // After each step. Throws std::runtime_error where it cannot be written.
  void Write(const Observation& observation);
  // Of events.log.
  void Note(const std::string& what, const std::string& is) { records_.Note(sim_.t_s(), what, is); }
  // When the flight is over; returns what summary.json says. error: why it broke off, empty: it did not.
  records::Summary Finish(const std::string& error);

 private:
  void WriteRows(std::size_t until);
  void WriteImage(const Observation& observation);

  const Sim& sim_;
  FlightRecords records_;
  std::size_t written_ = 0;  // rows
};

// The summary of a flight that ended so, whether it is recorded or not.
records::Summary SummaryOf(const Sim& sim, const std::string& error);

}  // namespace kestrel::flight
