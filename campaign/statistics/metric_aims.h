// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"

namespace kestrel::campaign {

enum class Better { kLower, kHigher };

// What the texts of a campaign say of its metrics.
struct MetricAims {
  std::vector<std::string> listed;  // that tables show first: the plan's, or those of the criteria
  // By metric: lower where a criterion or threshold sets but a maximum, higher where but a minimum.
  std::map<std::string, Better> better;
};
MetricAims AimsOf(const CampaignIdentity& identity);

// Every value of a YAML text by its dotted key, as it is written. Of no YAML: throws InputError.
std::map<std::string, std::string> ValuesOf(const std::string& yaml, const std::string& name);

}  // namespace kestrel::campaign
