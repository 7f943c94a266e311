// SPDX-License-Identifier: Apache-2.0
#include "campaign/tuning/flight_cost.h"

#include <algorithm>
#include <cmath>

namespace kestrel::campaign {
namespace {

double Worst(const CostTerm& term) { return term.worst.value_or(10 * term.scale); }

double Cost(const CostTerm& term, std::optional<double> value) {
  if (value && term.wanted) value = std::max(0.0, *term.wanted - *value);
  return term.weight * std::min(value.value_or(Worst(term)), Worst(term)) / term.scale;
}

double Penalty(const CostConstraint& constraint, std::optional<double> value) {
  if (!value) return 2 * constraint.penalty;
  double off = 0, limit = 1;
  if (constraint.max && *value > *constraint.max) off = *value - *constraint.max, limit = *constraint.max;
  if (constraint.min && *value < *constraint.min) off = *constraint.min - *value, limit = *constraint.min;
  if (off <= 0) return 0;
  return constraint.penalty * (1 + std::min(1.0, off / std::max(std::abs(limit), 1e-9)));
}

// Of a flight that was flown to its end.
std::optional<double> ValueIn(const RunResult& result, const std::string& metric) {
  const bool flown = result.status == RunStatus::kPassed || result.status == RunStatus::kFailed;
  const auto found = result.metrics.find(metric);
  if (!flown || found == result.metrics.end() || !std::isfinite(found->second)) return std::nullopt;
  return found->second;
}

}  // namespace

double CostOf(const RunResult& result, const FlightCost& cost) {
  double sum = result.status == RunStatus::kPassed ? 0 : cost.failure;
  for (const auto& [metric, term] : cost.terms) sum += Cost(term, ValueIn(result, metric));
  for (const auto& [metric, constraint] : cost.constraints)
    sum += Penalty(constraint, ValueIn(result, metric));
  return sum;
}

bool Keeps(const RunResult& result, const std::string& metric, const CostConstraint& constraint) {
  const std::optional<double> value = ValueIn(result, metric);
  return value && !(constraint.max && *value > *constraint.max) &&
         !(constraint.min && *value < *constraint.min);
}

}  // namespace kestrel::campaign
