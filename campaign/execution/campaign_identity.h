// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "campaign/table/sample_table.h"
#include "sim/machine.h"

namespace kestrel::campaign {

// What a result file is of. Two files belong together when they are of the same flights: all of it agrees,
// but for what a campaign's plan makes of the results (metrics, thresholds).
struct CampaignIdentity {
  std::string name;
  std::string scenario;  // as it resolves without the table: the YAML text
  std::string plan;      // the YAML text of the campaign's file
  std::string version;   // of the program
  SampleTable table;
  std::string file = {};      // of the campaign, when it was last flown or merged; no part of what it is
  std::string models = {};    // that its flights may be by, "NAME HASH" a line
  double limit_s = 0;         // of wall time, for a run
  sim::Machine machine = {};  // that its flights are flown on; empty: not known, as of older files
  bool tuning = false;        // the flights of a search: what a row flies with, the plan says alone
};

// In what two differ, a sentence each that names what: name, version, machine, models, plan, scenario, table;
// has: as "it has". None: they belong together. same_table: as far as is known beside the two.
std::vector<std::string> Differences(const CampaignIdentity& has, const CampaignIdentity& wanted,
                                     bool same_table = true);
// The names of the model files that are not alike, by CampaignIdentity::models.
std::vector<std::string> ModelsThatDiffer(const std::string& has, const std::string& wanted);

}  // namespace kestrel::campaign
