// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"
#include "campaign/execution/shard.h"
#include "campaign/execution/worker_pool.h"
#include "campaign/table/campaign_plan.h"

namespace kestrel::campaign {

// All that a campaign's runs depend on, and how long one may take.
struct CampaignWork {
  CampaignIdentity identity;
  std::string scenario;          // a name or a file
  std::vector<std::string> set;  // "key=value" for every run, before the row's
  double limit_s = 600;
};

// Of a campaign as it was read. rule: for how the campaign ends before its table does, as a line of text; it
// is a part of the plan, as what is counted depends on it. Throws InputError: the scenario is not valid.
CampaignWork WorkOf(const LoadedCampaign& campaign, const std::string& rule = {});

// The order for a row; folder: of its records.
RunOrder OrderFor(const CampaignWork& work, std::int64_t row,
                  const std::optional<std::filesystem::path>& folder = std::nullopt);

// How far a campaign, or a part of it, is.
struct Progress {
  std::int64_t rows = 0, done = 0, passed = 0;  // done: rows that have a result, passed of them
  std::int64_t counted = 0;                     // rows before the first one that has no result
  std::int64_t counted_passed = 0;              // of those
  std::int64_t flown = 0;                       // since this process began
  double wall_s = 0;                            // the same
  double Rate() const { return wall_s > 0 ? static_cast<double>(flown) / wall_s : 0; }  // runs a second
};

struct CampaignOptions {
  std::filesystem::path folder;  // of results, logs/ and recordings/ROW/
  int jobs = 1;                  // worker processes
  std::optional<Shard> shard;    // fly this part alone, into a file of its own
  // Of the rows that did not pass, the first so many are flown again with records. Which these are of the
  // whole table no part knows: each has its share of the number, rounded up.
  int record_failures = 10;
  std::vector<std::int64_t> record;  // and these, whatever they came to

  // A sequential rule: whether what is counted is enough. It is asked once for every row in the table's
  // order, as soon as all rows to it have results, so where it ends the campaign depends on neither the
  // number of workers nor who ends first; results beyond that row are dropped. Not with a shard.
  std::function<bool(const Progress&)> enough;
  std::function<void(const Progress&)> show;  // after each result, and some times a second

  // 0: go on. 1: begin no more runs, and end when those under way have. 2: end at once.
  const std::atomic<int>* stop = nullptr;
  std::vector<std::string> worker = WorkerCommand();
};

struct CampaignEnd {
  Progress progress;
  bool enough = false;                // the rule said so
  std::int64_t recorded = 0;          // flown again with records by this process
  std::vector<std::string> mistrust;  // of rows that came to something else the second time, a line each
  bool Complete() const { return enough || progress.done == progress.rows; }
};

// The result file of a folder, whole or of a part.
std::filesystem::path ResultFile(const std::filesystem::path& folder, const std::optional<Shard>& shard = {});
// Of a row's records.
std::filesystem::path RecordingFolder(const std::filesystem::path& folder, std::int64_t row);
// Processors that this process may use.
int Cores();

// Flies the rows that have no result yet, and stores each result as it comes. Throws InputError: the result
// file is another campaign's, or a row to be recorded is none; std::runtime_error: the disk is full, workers
// cannot be started, a file that flights are read from changed under way. What is stored by then stays,
// and is gone on with.
CampaignEnd RunCampaign(const CampaignWork& work, const CampaignOptions& options);

}  // namespace kestrel::campaign
