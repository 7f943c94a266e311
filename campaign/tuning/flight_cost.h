// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "base/yaml/fields.h"
#include "campaign/execution/run_result.h"

namespace kestrel::campaign {

// A metric in the cost of a flight: weight * metric / scale, the metric being no more than `worst`, which it
// also is of a flight that does not have it. Of a metric that is the better the more it is, what it lacks of
// `wanted` stands for it, also in `worst`.
struct CostTerm {
  double weight = 1;
  double scale = 1;
  std::optional<double> worst;
  std::optional<double> wanted;
};

inline void Fields(FieldVisitor& v, CostTerm& t) {
  v({"weight", "factor of this term in the cost: weight * metric / scale"}, t.weight, 0.0, 1e6);
  v(Required("scale", "value of the metric that counts as good, in the metric's unit"), t.scale, 1e-9, 1e9);
  v({"worst", "maximum value that counts, also of a flight without the metric; not given: ten times scale"},
    t.worst, 1e-9, 1e9);  // at 0 the term would be the same for all
  v({"wanted",
     "value of a metric that should be great: what it lacks of this counts; not given: the less the better"},
    t.wanted, -1e9, 1e9);
}

// What a metric must keep to. A flight that does not costs the penalty, and as much again by the share of the
// limit by which it is off, up to once more; one that does not have the metric costs it twice.
struct CostConstraint {
  std::optional<double> max, min;
  double penalty = 5;
};

inline void Fields(FieldVisitor& v, CostConstraint& c) {
  v({"max", "maximum value of the metric without a penalty"}, c.max, -1e9, 1e9);
  v({"min", "minimum value of the metric without a penalty"}, c.min, -1e9, 1e9);
  v({"penalty", "cost of a flight beyond a limit, up to twice by how far; twice without the metric"},
    c.penalty, 0.0, 1e6);
}

struct FlightCost {
  std::map<std::string, CostTerm> terms;
  std::map<std::string, CostConstraint> constraints;
  double failure = 0;  // of a flight that did not pass its scenario's criteria
};

// One that was not flown to its end has no metrics, whatever it left.
double CostOf(const RunResult& result, const FlightCost& cost);

// Whether a flight kept to a constraint on this metric; one that does not have it did not.
bool Keeps(const RunResult& result, const std::string& metric, const CostConstraint& constraint);

}  // namespace kestrel::campaign
