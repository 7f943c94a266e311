// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "campaign/execution/result_store.h"

namespace kestrel::campaign {

// The line by which a plan's text tells that the campaign ends when its share of successes is known to within
// so much, to either side: "--stop-when 0.02". It is a part of the plan, for what is counted depends on it.
std::string StopRule(double half_width);

// Of a campaign's plan; none: it flies its whole table. A campaign with a rule ends when its own results say
// so: its share has the interval of ShareSequence, no other.
std::optional<double> StopRuleOf(const CampaignIdentity& identity);

}  // namespace kestrel::campaign
