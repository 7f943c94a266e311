// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "campaign/execution/campaign_identity.h"
#include "campaign/execution/run_result.h"

namespace kestrel::campaign {

// The differences of a result file, by what is on the disk of it: what another machine is writing is left
// alone, and may not be seen yet. Nothing of what cannot be read.
std::vector<std::string> DifferencesOf(const std::filesystem::path& file, const CampaignIdentity& wanted);

// The results of a campaign in one SQLite file, with a write-ahead log: what Put returned from is there after
// whatever end of the program. The tables:
//   campaign   (key, value)                       name, scenario, plan, version, models, limit_s, table_hash,
//                                                 schema; keys: of the table in its order, a JSON list; kind:
//                                                 campaign or tuning
//   samples    (row, key, value)                  the table
//   runs       (row, status, outcome, state_hash, image_hash)
//   metrics    (row, name, value)
//   execution  (row, worker, wall_s, orchestration_s, peak_mib, log, recording)   depends on the machine
//   origin     (key, value)                       file: of the campaign; machine: that all of its flights
//   were flown
//                                                 on, a JSON object of names and values    likewise
// The first four of two campaigns on the same rows by the same version on machines that are alike are alike
// to the last bit. A metric that is not a number is NULL; the sign of zero is not kept.
class ResultStore {
 public:
  // Makes the file, or goes on with it, by the plan as it is now; the only writer until this object goes.
  // Throws InputError: it is another campaign's, another version's, damaged, or no result file at all, or
  // another process is at it; std::runtime_error: it cannot be written.
  static ResultStore Open(const std::filesystem::path& file, const CampaignIdentity& identity);
  // Reads it, while another process may be writing. Throws InputError, here or later: there is none, or it
  // is none, or it is damaged.
  static ResultStore Read(const std::filesystem::path& file);
  // The same of a campaign: the flights of a tuning are refused.
  static ResultStore ReadCampaign(const std::filesystem::path& file);
  ~ResultStore();
  ResultStore(ResultStore&&) noexcept;

  const CampaignIdentity& identity() const;
  // In one transaction, safe on the disk when it returns. Throws std::runtime_error, and nothing is changed:
  // the disk is full, or a row is there already, or is none of the table.
  void Put(const RunResult& result);
  void Put(const std::vector<RunResult>& results);
  // A row that has a result was flown again with records.
  void SetRecording(std::int64_t row, const std::string& folder);
  // Forgets the results of this row and all after it: those beyond the end that a sequential rule came to.
  void DropFrom(std::int64_t row);
  std::set<std::int64_t> Rows() const;     // that have a result
  std::vector<RunResult> Results() const;  // in the order of the rows

 private:
  struct Database;
  explicit ResultStore(std::unique_ptr<Database> database);
  std::unique_ptr<Database> database_;
};

}  // namespace kestrel::campaign
