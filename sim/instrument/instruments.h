// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>

#include "geometry/truth.h"
#include "sim/instrument/instrument_parameters.h"
#include "sim/instrument/readings.h"

namespace kestrel::sim {

// How far it is from a point along a unit vector, both in N, to what is there and is not the aircraft, m;
// infinite: nothing is.
using Beam = std::function<double(const Eigen::Vector3d& p_N, const Eigen::Vector3d& direction_N)>;

// The instruments of an aircraft: truth in, readings out, each at its own times, exact to the nanosecond. A
// reading is of the truth at its very instant, which between two steps of the physics is what Between() makes
// of the states on both sides (sim/instrument/motion.h). A rangefinder's beam leaves the aircraft where it
// then is, and meets what it meets where that was when the step began. Each instrument has random numbers of
// its own, so that one more changes none of the others, nor anything else of the flight.
class Instruments {
 public:
  Instruments(const InstrumentParameters& parameters, std::uint64_t seed);
  ~Instruments();

  // After each step, with the truth on both sides of it: makes the readings of instants after the one and no
  // later than the other; at the first call also those of its beginning. None is made before time 0.
  void Step(const Truth& before, const Truth& after, const Beam& beam);

  // Those that have come by then and were not taken yet.
  Readings Take(double t_s);

 private:
  struct Carried;
  std::unique_ptr<Carried> carried_;
};

}  // namespace kestrel::sim
