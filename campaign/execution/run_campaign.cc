// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/run_campaign.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <map>
#include <stdexcept>

#include "base/file/model_files.h"
#include "base/stopwatch.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/execution/scenario_files.h"
#include "flight/simulated/scenario.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;

constexpr double kTick_s = 0.2;

// Goes through a campaign's rows.
class Campaign {
 public:
  Campaign(const CampaignWork& work, const CampaignOptions& options)
      : work_(work),
        options_(options),
        files_(work.scenario, work.set, work.identity.table.keys),
        store_(MakeStore()) {
    const auto rows = static_cast<std::int64_t>(work.identity.table.rows.size());
    for (std::int64_t row = 0; row < rows; ++row)
      if (!options.shard || options.shard->Has(row)) rows_.push_back(row);
    for (const RunResult& result : store_.Results()) passed_[result.row] = Passed(result);
    for (const std::int64_t row : rows_)
      if (!passed_.contains(row)) missing_.push_back(row);
    end_.progress.rows = static_cast<std::int64_t>(rows_.size());
    end_.progress.done = end_.progress.rows - static_cast<std::int64_t>(missing_.size());
    for (const std::int64_t row : rows_) end_.progress.passed += passed_.contains(row) && passed_[row];
  }

  CampaignEnd Run() {
    Count();
    Show();
    if (!end_.enough && !missing_.empty()) FlyMissing();
    if (end_.enough) DropBeyond();
    if (Stop() == 0) Record();
    return end_;
  }

 private:
  static bool Passed(const RunResult& result) { return result.status == RunStatus::kPassed; }
  int Stop() const { return options_.stop ? options_.stop->load() : 0; }

  ResultStore MakeStore() const {
    std::error_code error;
    fs::create_directories(options_.folder, error);
    if (error)
      throw std::runtime_error(fmt::format("cannot write {}: {}", options_.folder.string(), error.message()));
    if (options_.shard) RefuseStrangers();
    return ResultStore::Open(ResultFile(options_.folder, options_.shard), work_.identity);
  }

  // Parts that lie beside results of another campaign would fly for nothing: merge refuses them.
  void RefuseStrangers() const {
    std::vector<fs::path> files = ShardFiles(options_.folder);
    files.insert(files.begin(), ResultFile(options_.folder));
    for (const fs::path& file : files) {
      Mistakes mistakes;
      if (fs::exists(file))
        for (const std::string& each : DifferencesOf(file, work_.identity))
          mistakes.Add(file.string(), "", each,
                       "valid: another folder (--out), or this file moved out of the way");
      mistakes.ThrowIfAny();
    }
  }

  void Put(const RunResult& result) {
    try {
      store_.Put(result);
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error& e) {
      throw std::runtime_error(
          fmt::format("{}; {} of {} runs are kept in it, and the same command goes on from there", e.what(),
                      end_.progress.done, end_.progress.rows));
    }
  }

  WorkerPool MakePool(std::size_t runs) const {
    fs::path logs = options_.folder / "logs";
    if (options_.shard) logs /= fmt::format("{}-of-{}", options_.shard->number, options_.shard->of);
    return WorkerPool(static_cast<int>(std::min(runs, static_cast<std::size_t>(options_.jobs))),
                      work_.limit_s, logs, options_.worker);
  }

  // Rows before the first without a result, asking the rule at each.
  void Count() {
    Progress& p = end_.progress;
    while (!end_.enough && p.counted < p.rows) {
      const auto found = passed_.find(rows_[static_cast<std::size_t>(p.counted)]);
      if (found == passed_.end()) return;
      ++p.counted;
      p.counted_passed += found->second;
      end_.enough = options_.enough && options_.enough(p);
    }
  }

  void Show() {
    end_.progress.wall_s = SecondsSince(began_);
    if (options_.show) options_.show(end_.progress);
  }

  void GiveNext(WorkerPool& pool) {
    while (!missing_.empty() && Stop() == 0 && pool.Idle()) {
      files_.RequireUnchanged();
      pool.Give(OrderFor(work_, missing_.front()));
      missing_.pop_front();
    }
  }

  void FlyMissing() {
    WorkerPool pool = MakePool(missing_.size());
    for (;;) {
      GiveNext(pool);
      if (pool.under_way() == 0 || Stop() > 1) return;
      const auto result = pool.WaitForResult(kTick_s);
      if (result) {
        GiveNext(pool);  // first, or its worker would wait for the disk
        Put(*result);
        passed_[result->row] = Passed(*result);
        ++end_.progress.done, ++end_.progress.flown;
        end_.progress.passed += Passed(*result);
        Count();
      }
      Show();
      if (end_.enough) return;  // what is under way is beyond the end
    }
  }

  void DropBeyond() {
    Progress& p = end_.progress;
    if (p.counted < p.rows) store_.DropFrom(rows_[static_cast<std::size_t>(p.counted)]);
    p.done = p.counted, p.passed = p.counted_passed;
  }

  // What is to be flown again with records: the first failures in the table's order, and what was asked for.
  // A run that took too long would again.
  std::map<std::int64_t, RunResult> ToRecord() const {
    std::map<std::int64_t, RunResult> rows;
    const int parts = options_.shard ? options_.shard->of : 1;
    const int most = options_.record_failures / parts + (options_.record_failures % parts > 0);
    int failures = 0;
    for (RunResult& result : store_.Results()) {
      const bool failure = result.status == RunStatus::kFailed || result.status == RunStatus::kBrokeOff ||
                           result.status == RunStatus::kCrashed;
      const bool asked =
          std::find(options_.record.begin(), options_.record.end(), result.row) != options_.record.end();
      if (!asked && !(failure && failures++ < most)) continue;
      if (result.execution.recording.empty()) rows.emplace(result.row, std::move(result));
    }
    return rows;
  }

  void Record() {
    const std::map<std::int64_t, RunResult> rows = ToRecord();
    if (rows.empty()) return;
    WorkerPool pool = MakePool(rows.size());
    for (auto next = rows.begin();;) {
      for (; next != rows.end() && Stop() == 0 && pool.Idle(); ++next)
        pool.Give(OrderFor(work_, next->first, RecordingFolder(options_.folder, next->first)));
      if (pool.under_way() == 0 || Stop() > 1) return;
      if (const auto again = pool.WaitForResult(kTick_s)) {
        store_.SetRecording(again->row, again->execution.recording);
        ++end_.recorded;
        const std::string difference = DifferenceOf(rows.at(again->row), *again);
        if (!difference.empty()) end_.mistrust.push_back(fmt::format("row {}: {}", again->row, difference));
      }
      Show();
    }
  }

  const CampaignWork& work_;
  const CampaignOptions& options_;
  ScenarioFiles files_;
  ResultStore store_;
  std::vector<std::int64_t> rows_;       // of this part of the table
  std::map<std::int64_t, bool> passed_;  // of the rows that have a result
  std::deque<std::int64_t> missing_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  CampaignEnd end_;
};

}  // namespace

CampaignWork WorkOf(const LoadedCampaign& campaign, const std::string& rule) {
  CampaignWork work;
  work.scenario = campaign.plan.scenario;
  work.set = campaign.plan.set;
  work.limit_s = campaign.plan.limit_s;
  work.identity = {campaign.plan.name, ToYaml(flight::LoadScenario(work.scenario, work.set).scenario),
                   campaign.text,      Version(),
                   campaign.table,     campaign.file};
  work.identity.models = ScenarioFiles(work.scenario, work.set, campaign.table.keys).Models();
  work.identity.limit_s = work.limit_s;
  work.identity.machine = sim::ThisMachine();
  if (!rule.empty()) work.identity.plan += fmt::format("\n# {}\n", rule);
  return work;
}

RunOrder OrderFor(const CampaignWork& work, std::int64_t row, const std::optional<fs::path>& folder) {
  RunOrder order{row, work.scenario, work.set, folder, folder.has_value()};
  for (std::string& each : OverridesOf(work.identity.table, static_cast<std::size_t>(row)))
    order.overrides.push_back(std::move(each));
  return order;
}

fs::path ResultFile(const fs::path& folder, const std::optional<Shard>& shard) {
  return folder / (shard ? FileNameOf(*shard) : "results.sqlite");
}

fs::path RecordingFolder(const fs::path& folder, std::int64_t row) {
  return folder / "recordings" / std::to_string(row);
}

int Cores() {
  cpu_set_t mine;
  return sched_getaffinity(0, sizeof mine, &mine) == 0 ? CPU_COUNT(&mine) : 1;
}

CampaignEnd RunCampaign(const CampaignWork& work, const CampaignOptions& options) {
  for (const std::int64_t row : options.record)
    if (row < 0 || row >= static_cast<std::int64_t>(work.identity.table.rows.size()))
      throw InputError(
          "--record", fmt::format("there is no row {}", row),
          fmt::format("valid: 0 to {}", static_cast<std::int64_t>(work.identity.table.rows.size()) - 1));
  return Campaign(work, options).Run();
}

}  // namespace kestrel::campaign
