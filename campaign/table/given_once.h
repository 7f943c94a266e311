// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/yaml/config.h"
#include "campaign/table/campaign_plan.h"

namespace kestrel::campaign {

// Refuses a key that a plan sets twice, a key that varies within another that does, and a metric that is
// listed twice: one of them would be without effect.
void CheckGivenOnce(const ConfigNode& root, const CampaignPlan& plan, Mistakes& mistakes);

}  // namespace kestrel::campaign
