// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <string>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"

// Whether to touch down: the limits, the rule that is asked for each frame of the way down, and what becomes of an
// approach that is broken off.
namespace kestrel::mission {

// What a touch-down must keep to.
struct TouchDownLimits {
  double tilt_deg = 12;
  double sink_m_s = 0.6;
  double speed_m_s = 0.6;
  double wind_m_s = 9;
};

inline void Fields(FieldVisitor& v, TouchDownLimits& p) {
  v({"tilt_deg", "maximum angle between the aircraft and the pad at touch-down"}, p.tilt_deg, 1.0, 45.0);
  v({"sink_m_s", "maximum speed into the pad at touch-down"}, p.sink_m_s, 0.1, 5.0);
  v({"speed_m_s", "maximum speed along the pad at touch-down"}, p.speed_m_s, 0.1, 5.0);
  v({"wind_m_s", "maximum wind, as the aircraft's lean tells it, in which to go below the decision height"},
    p.wind_m_s, 0.5, 40.0);
}

struct GoAroundParameters {
  double decision_m = 1.5;
  double share = 0.7;
  double steady_s = 1;
  bool wait_first = false;
  double lead_s = 0.15;
  double wait_s = 8;
  int attempts = 3;
  double climb_m_s = 0.8;
};

inline void Fields(FieldVisitor& v, GoAroundParameters& p) {
  v({"decision_m",
     "height above the pad at which the aircraft waits until it may go down, and to which a go-around "
     "climbs"},
    p.decision_m, 0.3, 20.0);
  v({"share", "share of each limit of the touch-down above which the aircraft does not go on down"}, p.share,
    0.1, 1.0);
  v({"steady_s", "time for which all is within that share before the aircraft goes down"}, p.steady_s, 0.0,
    30.0);
  v({"wait_first",
     "whether the first approach, too, waits for all of that; if not, it waits for the wind alone"},
    p.wait_first);
  v({"lead_s", "time ahead for which the tilt is predicted by its rate"}, p.lead_s, 0.0, 1.0);
  v({"wait_s", "longest wait at the decision height, after which the approach counts as broken off"},
    p.wait_s, 0.0, 600.0);
  v({"attempts", "number of approaches, after which the flight ends as aborted"}, p.attempts, 1, 20);
  v({"climb_m_s", "climb rate of a go-around"}, p.climb_m_s, 0.1, 3.0);
}

// What touching down now, or soon, would be like.
struct ExpectedTouch {
  double tilt = 0;       // rad, between aircraft and pad
  double sink_m_s = 0;   // into the pad
  double speed_m_s = 0;  // along it
  double wind_m_s = 0;
};

// The rule. Above the decision height an approach is free. It goes below once the wind has been within its limit, and
// everything else within its share of the limits, for a while, and not for longer than a wait. Below the height of the
// last look it is broken off as soon as something is not: the aircraft climbs back to the decision height for its next
// approach, and after the last one the flight is aborted.
class GoAround {
 public:
  enum class Advice {
    kApproach,  // go on as ever
    kWait,      // hold the decision height
    kGoAround,  // climb to the decision height
    kAbort      // the same, and end there
  };

  GoAround(const TouchDownLimits& limits, const GoAroundParameters& parameters)
      : limits_(limits), parameters_(parameters) {}

  // Each frame in which the aircraft knows its height above the pad. last_look_m: height below which an approach is
  // broken off for what is expected.
  Advice Ask(double t_s, double height_m, double last_look_m, const ExpectedTouch& expected);
  // Breaks the approach off, whatever is expected: the pad is lost where it must be seen.
  Advice BreakOff();

  bool climbing() const { return climbing_; }
  bool aborted() const { return broken_off_ >= parameters_.attempts; }
  bool committed() const { return committed_; }  // it has passed the decision height on its way down
  int attempt() const { return std::min(broken_off_ + 1, parameters_.attempts); }

 private:
  bool Exceeded(const ExpectedTouch& expected) const;

  TouchDownLimits limits_;
  GoAroundParameters parameters_;
  // The last times at which something, or the wind, was not.
  double exceeded_s_ = -std::numeric_limits<double>::infinity();
  double windy_s_ = -std::numeric_limits<double>::infinity();
  double waits_since_s_ = -1;  // negative: it does not
  int broken_off_ = 0;         // approaches
  bool committed_ = false, climbing_ = false;
};

// A last look above the decision height. where: of the flight's keys.
void CheckGoAround(const GoAroundParameters& parameters, double last_look_m, const std::string& last_look_key,
                   const Place& where, Mistakes& mistakes);

}  // namespace kestrel::mission
