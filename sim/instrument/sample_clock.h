// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "base/nanoseconds.h"
#include "sim/instrument/instrument_parameters.h"

namespace kestrel::sim {

// When an instrument measures: the k-th time at phase + round(k 1e9 / rate) ns, reckoned from k each time, so
// that nothing adds up.
class SampleClock {
 public:
  SampleClock(double rate_hz, double phase_s) : rate_hz_(rate_hz), phase_ns_(Nanoseconds(phase_s)) {}

  std::int64_t next_ns() const {
    return phase_ns_ + std::llround(static_cast<double>(count_) * 1e9 / rate_hz_);
  }
  void Tick() { ++count_; }

 private:
  double rate_hz_;
  std::int64_t phase_ns_, count_ = 0;
};

// The readings of an instrument from when they are made until they have come.
template <class Reading>
class ReadingsUnderWay {
 public:
  explicit ReadingsUnderWay(const SampleTiming& timing)
      : latency_ns_(Nanoseconds(timing.latency_s)), offset_ns_(Nanoseconds(timing.clock_offset_s)) {}

  // t_ns: of the flight; the reading gets its stamp here.
  void Send(std::int64_t t_ns, Reading reading) {
    reading.t_ns = t_ns + offset_ns_;
    coming_.push_back(std::move(reading));
  }
  // Those that have come by then.
  std::vector<Reading> Take(std::int64_t now_ns) {
    std::vector<Reading> come;
    for (; !coming_.empty() && coming_.front().t_ns - offset_ns_ + latency_ns_ <= now_ns; coming_.pop_front())
      come.push_back(std::move(coming_.front()));
    return come;
  }

 private:
  std::int64_t latency_ns_, offset_ns_;
  std::deque<Reading> coming_;
};

}  // namespace kestrel::sim
