// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/campaign/compare_command.h"
#include "app/campaign/report_command.h"
#include "campaign/execution/run_campaign.h"

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel campaign`: many flights, what varies among them being in a file.
struct CampaignArguments {
  std::string file;  // or a name: scenarios/FLIGHT/campaigns/NAME.yaml
  std::vector<std::string> overrides;
  std::string runs, seed;
  std::string out;  // folder; empty: results/campaigns/NAME
  int jobs = 0;     // 0: one for each core
  std::string shard;
  int record_failures = 10;
  std::vector<std::int64_t> record;
  std::optional<double> stop_when;
  std::string junit;  // of the thresholds
  bool quiet = false;

  std::int64_t row = 0;             // of replay
  bool no_video = false;            // of replay
  std::vector<std::string> shards;  // of merge
  int tasks = 0;                    // of slurm and parallel

  CampaignReportArguments report;
  CompareArguments compare;

  enum class Verb { kFly, kReplay, kMerge, kSlurm, kParallel, kReport, kCompare } verb = Verb::kFly;
};

CLI::App* AddCampaignCommand(CLI::App& app, CampaignArguments& arguments);

// Throws InputError with every mistake, std::runtime_error for what breaks it off. False: it came to an end,
// but a threshold is not kept, rows are missing, a replay came to something else, or B is worse than A.
bool CampaignCommand(const CampaignArguments& arguments);

// The file of a campaign by its name or itself.
std::filesystem::path CampaignFile(const std::string& name_or_file);

}  // namespace kestrel::app
