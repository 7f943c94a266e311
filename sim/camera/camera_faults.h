// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A fault of the camera, in the vocabulary of PX4's failure injection. What becomes of the frames whose
// exposure falls into it:
//
//   off           there are none, and their numbers (Frame::sequence) are missing
//   intermittent  each is lost with a chance of loss, and its number is missing
//   slow          rate_hz of them are made in a second and no others: the numbers go on without a gap
//   delayed       they come delay_s later than the latency says, none before the one exposed before it; those
//                 that an end of the fault lets overtake come right after one another
//   stuck         number and time go on, the image is the last from before; without one, the first
//   garbage       number and time go on, the pixels are random
//
// Faults may meet: off beats all, then intermittent and slow decide what there is, stuck beats garbage, and
// the delays add up.
struct CameraFault {
  std::string type;
  // While: the whole of [from_s, until_s); or, with a rate_per_min, lengths of length_s of it that begin at
  // random, so often a minute.
  double from_s = 0, until_s = 1e9;
  double rate_per_min = 0, length_s = 1;
  double probability = 1;  // that there is this fault at all, by the seed
  double loss = 0.5;       // intermittent
  double rate_hz = 2;      // slow
  double delay_s = 0.3;    // delayed
};

inline void Fields(FieldVisitor& v, CameraFault& f) {
  v(Required("type", "what becomes of the frames, in the vocabulary of PX4's failure injection"), f.type,
    {"off", "stuck", "garbage", "slow", "delayed", "intermittent"});
  v({"from_s", "when the fault begins, in the time of the flight"}, f.from_s, 0.0, 1e9);
  v({"until_s", "when the fault ends"}, f.until_s, 0.0, 1e9);
  v({"rate_per_min",
     "how often in a minute the fault comes, at random, between from_s and until_s; 0: it lasts all that "
     "time"},
    f.rate_per_min, 0.0, 600.0);
  v({"length_s", "how long it lasts each time, with a rate_per_min"}, f.length_s, 0.001, 1e9);
  v({"probability", "chance that a run has this fault at all, by the seed"}, f.probability, 0.0, 1.0);
  if (f.type == "intermittent") v({"loss", "chance of each frame to be lost"}, f.loss, 0.0, 1.0);
  if (f.type == "slow") v({"rate_hz", "frames that are still made in a second"}, f.rate_hz, 0.01, 500.0);
  if (f.type == "delayed")
    v({"delay_s", "how much later than image.latency_s frames come"}, f.delay_s, 0.0, 60.0);
}

// How the camera is from a time on.
struct CameraCondition {
  double from_s = 0;
  std::string name = "ok";  // or the faults that it has: "off", "slow + delayed"
  bool off = false, stuck = false, garbage = false;
  double loss = 0;      // chance of each frame
  double period_s = 0;  // at least, between two frames
  double delay_s = 0;
  bool operator==(const CameraCondition&) const = default;
};

// The faults of one run, settled before it begins: schedule, seed and duration decide.
class CameraFaults {
 public:
  CameraFaults(const std::vector<CameraFault>& faults, std::uint64_t seed, double duration_s);

  // What has been until t_s stays, what is later is by these.
  void Change(const CameraFaults& later, double t_s);

  const CameraCondition& At(double t_s) const;
  // Every change up to a time, its own included; none while there has been no fault.
  std::span<const CameraCondition> ChangesUntil(double t_s) const;
  // Whether an intermittent camera loses the frame that it should take at a place of its clock.
  bool Loses(const CameraCondition& condition, std::int64_t tick) const;

 private:
  std::uint64_t seed_;
  std::vector<CameraCondition> conditions_;  // in the order of time; the first has no beginning
};

}  // namespace kestrel::sim
