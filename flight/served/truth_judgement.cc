// SPDX-License-Identifier: Apache-2.0
#include "flight/served/truth_judgement.h"

#include <map>

#include "flight/simulated/judgement.h"
#include "records/telemetry/metrics.h"

namespace kestrel::flight {

void JudgeByTruth(const Scenario& scenario, const std::vector<records::LogRow>& rows,
                  const std::optional<Truth>& touch, const std::function<void(const std::string&)>& say,
                  records::Summary& summary) {
  for (const auto& [name, value] : records::Metrics(rows, touch, nullptr))
    if (!records::NeedsDecisions(name)) summary.metrics[name] = value;
  std::map<std::string, Limit> limits = scenario.criteria;
  std::erase_if(limits, [&](const auto& limit) {
    const bool out = records::NeedsDecisions(limit.first);
    if (out) say(limit.first + " is left out: only the flight code knows it");
    return out;
  });
  Judge(limits, summary);
  summary.passed = summary.complete && AllPassed(summary.criteria);
}

}  // namespace kestrel::flight
