// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "campaign/table/campaign_plan.h"

namespace kestrel::campaign {

// The metrics that flights of a plan can have, to refuse any other before anything flies.
class FlightMetrics {
 public:
  // A scenario that is none or not valid, or a mission that varies, may have them all.
  explicit FlightMetrics(const CampaignPlan& plan);
  // also: names that are valid there beside them. All that are is said with the first mistake alone.
  void Check(const std::string& metric, const std::vector<std::string>& also, const Place& where,
             const std::string& path, Mistakes& mistakes);

 private:
  std::vector<std::string> own_;
  std::string mission_;  // empty: unknown
  bool all_reported_ = false;
};

}  // namespace kestrel::campaign
