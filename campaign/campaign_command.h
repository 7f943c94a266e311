// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "campaign/campaign_plan.h"
#include "campaign/run_campaign.h"

namespace CLI {
class App;
}

namespace kestrel {

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
  bool quiet = false;

  std::int64_t row = 0;             // of replay
  bool no_video = false;            // of replay
  std::vector<std::string> shards;  // of merge
  int tasks = 0;                    // of slurm and parallel

  enum class Verb { kFly, kReplay, kMerge, kSlurm, kParallel } verb = Verb::kFly;
};

// What statistics say of a campaign under way.
struct CampaignStatistics {
  // Of the share that passed, as text: "[0.93, 0.99]".
  std::function<std::string(std::int64_t passed, std::int64_t runs)> interval;
  // Whether it is known to within half of this width, by a rule that may be asked after every run.
  std::function<bool(std::int64_t passed, std::int64_t runs, double half_width)> narrow_enough;
};

CLI::App* AddCampaignCommand(CLI::App& app, CampaignArguments& arguments);

// Throws InputError with every mistake, std::runtime_error for what breaks it off. False: it came to an end,
// but rows are missing, or a replay came to something else. Hidden beside it is `campaign-worker`:
// WorkerMain().
bool CampaignCommand(const CampaignArguments& arguments, const CampaignStatistics& statistics);

// The file of a campaign by its name or itself.
std::filesystem::path CampaignFile(const std::string& name_or_file);

}  // namespace kestrel
