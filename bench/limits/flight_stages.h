// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

namespace kestrel::bench {

// What a frame of a flight costs, and how fast the flight is.
struct FlightStages {
  // By their names in summary.json, the mean a frame, all on one core; of physics without the render and the sensor
  // that its steps ask for.
  std::map<std::string, double> stages_ms;
  double frame_s = 0;             // flown from frame to frame
  double by_one = 0, by_two = 0;  // measured multiples of real time
  // If two cores shared what one does without a gap: no flight is faster on them.
  double AtMostByTwo() const { return 2 * by_one; }
};

// Flies the first seconds on one core and on as many as its loop takes, in turn and several times: the fastest. Throws
// InputError.
FlightStages StagesOfFlight(const std::string& scenario, double duration_s);

}  // namespace kestrel::bench
