// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "campaign/run_result.h"
#include "campaign/sample_table.h"

namespace kestrel {

// What a result file is of. Two files belong together when their names, versions, plans and tables agree.
struct CampaignIdentity {
  std::string name;
  std::string scenario;  // as it resolves without the table: the YAML text
  std::string plan;      // the YAML text of the campaign's file
  std::string version;   // of the program
  SampleTable table;
};

// The results of a campaign in one SQLite file, with a write-ahead log: what Put returned from is there after
// whatever end of the program. The tables:
//   campaign   (key, value)                       name, scenario, plan, version, table_hash, schema
//   samples    (row, key, value)                  the table
//   runs       (row, status, outcome, state_hash, image_hash)
//   metrics    (row, name, value)
//   execution  (row, worker, wall_s, orchestration_s, peak_mib, log, recording)   depends on the machine
// The first four of two campaigns on the same rows by the same version are alike to the last bit.
class ResultStore {
 public:
  // Makes the file, or goes on with it. Throws InputError: it is another campaign's, another version's, or no
  // result file at all; std::runtime_error: it cannot be written.
  static ResultStore Open(const std::filesystem::path& file, const CampaignIdentity& identity);
  // Reads it, while another process may be writing. Throws InputError: there is none, or it is none.
  static ResultStore Read(const std::filesystem::path& file);
  ~ResultStore();
  ResultStore(ResultStore&&) noexcept;

  const CampaignIdentity& identity() const;
  // In one transaction, safe on the disk when it returns. Throws std::runtime_error: the disk is full, or the
  // row is there already.
  void Put(const RunResult& result);
  std::set<std::int64_t> Rows() const;     // that have a result
  std::vector<RunResult> Results() const;  // in the order of the rows

 private:
  struct Database;
  explicit ResultStore(std::unique_ptr<Database> database);
  std::unique_ptr<Database> database_;
};

}  // namespace kestrel
