// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/run_campaign.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <random>
#include <set>
#include <thread>

#include "base/stopwatch.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/execution/batch_script.h"
#include "tests/campaign/results.h"
#include "tests/campaign/scripted_worker.h"
#include "tests/campaign/tables.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::Lt;

// Campaigns of rows that scripted workers fly: what they do with a row is in its key "do".
class RunCampaignTest : public InTemporaryFolder {
 protected:
  static CampaignWork Work(const std::vector<std::string>& what) {
    SampleTable table{{"seed", "do"}, {}};
    for (std::size_t row = 0; row < what.size(); ++row)
      table.rows.push_back({fmt::format("{}", row), what[row]});
    return {IdentityOf(table), "hover", {}, 60};
  }
  static CampaignWork Work(int rows, const std::string& what = "") {
    return Work(std::vector<std::string>(static_cast<std::size_t>(rows), what));
  }
  CampaignOptions Options(const std::string& name, int jobs) const {
    CampaignOptions options;
    options.folder = folder_ / name;
    options.jobs = jobs;
    options.record_failures = 0;
    options.worker = ScriptedWorker(folder_);
    return options;
  }
};

TEST_F(RunCampaignTest, TheTableIsTheSameForAnyNumberOfWorkers) {
  const CampaignWork work = Work({"", "wait 0.05", "fail", "crash", "", "wait 0.02", "", "be refused",
                                  "break off", "crash once", "be killed once", "", ""});
  std::string first;
  for (const int jobs : {1, 2, 5}) {
    const std::string name = fmt::format("{}", jobs);
    for (const int row : {9, 10}) {
      fs::remove(folder_ / fmt::format("crashed-{}", row));
      fs::remove(folder_ / fmt::format("killed-{}", row));
    }
    const CampaignEnd end = RunCampaign(work, Options(name, jobs));
    EXPECT_TRUE(end.Complete());
    EXPECT_EQ(end.progress.flown, 13);
    const std::string tables = TablesOf(folder_ / name / "results.sqlite");
    if (first.empty()) first = tables;
    EXPECT_EQ(tables, first) << jobs << " workers";
  }
  EXPECT_THAT(first, AllOf(HasSubstr("3 crashed killed by SIGSEGV"), HasSubstr("7 refused scripted"),
                           HasSubstr("8 broke off scripted"), HasSubstr("9 failed scripted"),
                           HasSubstr("10 passed scripted")));
}

TEST_F(RunCampaignTest, GoesOnWithWhatIsMissingAndFliesNothingTwice) {
  const CampaignWork work = Work(10);
  std::atomic<int> stop = 0;
  CampaignOptions options = Options("a", 2);
  options.stop = &stop;
  options.show = [&](const Progress& p) {
    if (p.done >= 4) stop = 1;
  };
  const CampaignEnd interrupted = RunCampaign(work, options);
  EXPECT_FALSE(interrupted.Complete());
  // What was under way at the interrupt has its results.
  EXPECT_THAT(interrupted.progress.done, AllOf(Ge(4), Lt(10)));
  EXPECT_EQ(RowsIn(folder_ / "given.txt").size(), interrupted.progress.done);

  const CampaignEnd end = RunCampaign(work, Options("a", 2));
  EXPECT_TRUE(end.Complete());
  EXPECT_EQ(end.progress.flown, 10 - interrupted.progress.done);
  auto flown = RowsIn(folder_ / "flown.txt");
  std::sort(flown.begin(), flown.end());
  EXPECT_THAT(flown, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));

  EXPECT_EQ(RunCampaign(work, Options("a", 2)).progress.flown, 0);
  EXPECT_EQ(RowsIn(folder_ / "given.txt").size(), 10);
}

TEST_F(RunCampaignTest, TheSecondInterruptDropsWhatIsUnderWay) {
  std::atomic<int> stop = 0;
  CampaignOptions options = Options("a", 2);
  options.stop = &stop;
  options.show = [&](const Progress& p) {
    if (p.done >= 1) stop = 2;
  };
  const double start_s = MonotonicNow_s();
  const CampaignEnd end = RunCampaign(Work({"", "wait 500", "wait 500", "wait 500"}), options);
  EXPECT_LT(MonotonicNow_s() - start_s, 100);
  EXPECT_EQ(end.progress.done, 1);
  EXPECT_FALSE(end.Complete());
}

TEST_F(RunCampaignTest, KillingTheParentLosesNothingButTheRunsUnderWayAndNothingIsTwice) {
  constexpr int kRows = 40, kJobs = 2;
  const CampaignWork work = Work(kRows, "wait 0.01");
  std::mt19937 random(7);
  std::set<std::int64_t> before;
  int kills = 0;
  for (bool complete = false; !complete;) {
    const pid_t parent = fork();
    if (parent == 0) {
      try {
        RunCampaign(work, Options("killed", kJobs));
        _exit(0);
      } catch (const std::exception& e) {
        std::fputs(e.what(), stderr);
        _exit(1);
      }
    }
    int status = 0;
    if (kills < 6) {
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 400));
      ++kills;
      kill(parent, SIGKILL);
    }
    waitpid(parent, &status, 0);
    complete = WIFEXITED(status);
    EXPECT_TRUE(!complete || WEXITSTATUS(status) == 0);
    if (!fs::exists(folder_ / "killed/results.sqlite") ||
        fs::file_size(folder_ / "killed/results.sqlite") == 0)
      continue;
    std::set<std::int64_t> rows;
    try {
      rows = ResultStore::Read(folder_ / "killed/results.sqlite").Rows();
    } catch (const InputError&) {  // killed before there were tables
      EXPECT_THAT(before, IsEmpty());
    }
    EXPECT_TRUE(std::includes(rows.begin(), rows.end(), before.begin(), before.end()));
    before = rows;
  }
  EXPECT_EQ(before.size(), kRows);
  // A worker can have one run under way, and one that it has reported and that is not stored yet.
  EXPECT_LE(RowsIn(folder_ / "flown.txt").size(), kRows + kills * kJobs * 2);
  RunCampaign(work, Options("whole", 1));
  EXPECT_EQ(TablesOf(folder_ / "killed/results.sqlite"), TablesOf(folder_ / "whole/results.sqlite"));
}

TEST_F(RunCampaignTest, KillingWorkersChangesNothing) {
  constexpr int kRows = 30;
  const CampaignWork work = Work(kRows, "wait 0.02");
  const pid_t parent = fork();
  if (parent == 0) {
    try {
      _exit(RunCampaign(work, Options("killed", 2)).progress.passed == kRows - kRows / 5 ? 0 : 1);
    } catch (const std::exception& e) {
      std::fputs(e.what(), stderr);
      _exit(2);
    }
  }
  std::mt19937 random(3);
  int status = 0, kills = 0;
  while (waitpid(parent, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + random() % 100));
    if (kills >= 8) continue;
    std::ifstream in(fmt::format("/proc/{0}/task/{0}/children", parent));
    std::vector<pid_t> workers;
    for (pid_t each; in >> each;) workers.push_back(each);
    if (!workers.empty() && kill(workers[random() % workers.size()], SIGKILL) == 0) ++kills;
  }
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_GT(kills, 0);
  RunCampaign(work, Options("whole", 1));
  EXPECT_EQ(TablesOf(folder_ / "killed/results.sqlite"), TablesOf(folder_ / "whole/results.sqlite"));
}

TEST_F(RunCampaignTest, ARuleEndsItAtTheSameRowWhateverTheWorkers) {
  // The rows that come early end late.
  std::vector<std::string> what;
  for (int row = 0; row < 60; ++row) what.push_back(row % 4 == 0 ? "wait 0.1" : "");
  const CampaignWork work = Work(what);
  std::string first;
  for (const int jobs : {1, 2, 5}) {
    CampaignOptions options = Options(fmt::format("{}", jobs), jobs);
    std::vector<std::int64_t> asked;
    options.enough = [&](const Progress& p) {
      asked.push_back(p.counted);
      return p.counted_passed >= 10;
    };
    const CampaignEnd end = RunCampaign(work, options);
    EXPECT_TRUE(end.enough);
    EXPECT_TRUE(end.Complete());
    EXPECT_EQ(end.progress.done, 12);  // of which rows 4 and 9 fail
    EXPECT_THAT(asked, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12));
    const std::string tables = TablesOf(options.folder / "results.sqlite");
    if (first.empty()) first = tables;
    EXPECT_EQ(tables, first) << jobs;

    // And starting again ends at once.
    EXPECT_EQ(RunCampaign(work, options).progress.flown, 0);
    EXPECT_EQ(TablesOf(options.folder / "results.sqlite"), first);
  }
}

TEST_F(RunCampaignTest, ShardsJoinedAreTheSameTableAndALostOneIsNamed) {
  const CampaignWork work = Work({"", "", "crash", "", "", "fail", "", ""});
  RunCampaign(work, Options("whole", 2));
  CampaignOptions options = Options("parts", 2);
  for (const int number : {1, 2, 3}) {
    options.shard = Shard{number, 3};
    const CampaignEnd end = RunCampaign(work, options);
    EXPECT_EQ(end.progress.rows, number == 3 ? 2 : 3);
  }
  const auto part = [&](int number) { return options.folder / FileNameOf({number, 3}); };
  const fs::path into = options.folder / "results.sqlite";
  const Merged lost = Merge(into, work.identity, {part(1), part(3)});
  EXPECT_EQ(lost.added, 5);
  EXPECT_THAT(lost.missing, ElementsAre(1, 4, 7));
  const Merged all = Merge(into, work.identity, {part(1), part(2), part(3)});
  EXPECT_EQ(all.added, 3);
  EXPECT_EQ(all.there, 5);
  EXPECT_THAT(all.missing, IsEmpty());
  EXPECT_EQ(TablesOf(into), TablesOf(folder_ / "whole/results.sqlite"));
}

TEST_F(RunCampaignTest, PartsOfOtherCampaignsAndOtherResultsAreNotJoined) {
  const CampaignWork work = Work(4);
  fs::create_directory(folder_ / "parts");
  const auto part = [&](int number, const CampaignIdentity& identity, std::vector<RunResult> results) {
    const fs::path file = folder_ / "parts" / FileNameOf({number, 4});
    ResultStore::Open(file, identity).Put(results);
    return file;
  };
  CampaignIdentity other = work.identity;
  other.version = "0.2.0";
  const auto why = [&](const std::vector<fs::path>& parts) -> std::string {
    try {
      Merge(folder_ / "results.sqlite", work.identity, parts);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  const fs::path one = part(1, work.identity, {ResultOf(0)}), two = part(2, other, {ResultOf(1)});
  EXPECT_THAT(
      why({one, two, folder_ / "none.sqlite"}),
      AllOf(HasSubstr(two.string() + ": version: it is of 0.2.0"), HasSubstr("none.sqlite: there is no")));
  other = work.identity;
  other.table.rows[3][1] = "crash";
  EXPECT_THAT(why({one, part(3, other, {})}), HasSubstr("table: it is of another: row 3"));
  RunResult result = ResultOf(0);
  result.metrics["error_m"] += 1e-15;
  EXPECT_THAT(why({one, part(4, work.identity, {result})}),
              AllOf(HasSubstr("row 0 came to something else than in " + one.string()), HasSubstr("error_m")));
  EXPECT_FALSE(fs::exists(folder_ / "results.sqlite"));
}

TEST_F(RunCampaignTest, PartsOfMachinesThatAreAlikeAreJoinedWhereverThatIsDone) {
  CampaignIdentity here = Work(4).identity;
  here.machine = {{"instruction_set", "avx512"}, {"mujoco", "2.2.2"}};
  fs::create_directory(folder_ / "parts");
  const auto part = [&](int number, const std::string& set, std::vector<RunResult> results) {
    const fs::path file = folder_ / "parts" / FileNameOf({number, 4});
    CampaignIdentity identity = here;
    identity.machine["instruction_set"] = set;
    ResultStore::Open(file, identity).Put(results);
    return file;
  };
  const fs::path one = part(1, "avx2", {ResultOf(0)}), two = part(2, "avx2", {ResultOf(1)});
  const fs::path three = part(3, "avx512", {ResultOf(2)}), into = folder_ / "results.sqlite";
  const auto why = [&](const std::vector<fs::path>& parts) -> std::string {
    try {
      Merge(into, here, parts);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(why({one, three}), AllOf(HasSubstr(three.string() + ": machine: "),
                                       HasSubstr("instruction_set avx512 and not avx2"), HasSubstr("--isa")));
  EXPECT_FALSE(fs::exists(into));
  EXPECT_EQ(Merge(into, here, {one, two}).added, 2);
  EXPECT_EQ(ResultStore::Read(into).identity().machine.at("instruction_set"), "avx2");
  // Nor to what was joined before.
  EXPECT_THAT(why({three}), HasSubstr(into.string() + ": machine: "));
}

TEST_F(RunCampaignTest, APartDoesNotFlyBesideResultsOfAnotherCampaign) {
  CampaignWork other = Work(6);
  other.identity.plan += "\n# --set seed=2\n";
  const auto refusal = [&](int number) -> std::string {
    CampaignOptions options = Options("parts", 1);
    options.shard = Shard{number, 3};
    try {
      RunCampaign(Work(6), options);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(1), "");
  CampaignOptions options = Options("parts", 1);
  options.shard = Shard{2, 3};
  EXPECT_THROW(RunCampaign(other, options), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "parts/results-2-of-3.sqlite"));
  EXPECT_EQ(refusal(2), "");
  // Nor beside a whole one.
  const fs::path whole = folder_ / "parts/results.sqlite";
  { ResultStore::Open(whole, other.identity); }
  EXPECT_THAT(refusal(3), AllOf(HasSubstr(whole.string() + ": plan: flown with --seed 2, now without"),
                                HasSubstr("valid: another folder (--out), or this file moved")));
  fs::remove(whole);
  { ResultStore::Open(whole, Work(6).identity); }
  EXPECT_EQ(refusal(3), "");
}

TEST_F(RunCampaignTest, PartsShareTheFailuresToBeRecorded) {
  int recorded = 0;
  for (const int number : {1, 2, 3}) {
    CampaignOptions options = Options("parts", 2);
    options.shard = Shard{number, 3};
    options.record_failures = 4;
    recorded += static_cast<int>(RunCampaign(Work(18, "fail"), options).recorded);
  }
  EXPECT_EQ(recorded, 3 * 2);
}

TEST_F(RunCampaignTest, ADiskThatIsFullIsToldWithWhatIsKept) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  CampaignOptions options = Options("a", 1);
  options.show = [&](const Progress& p) {
    if (p.done < 3) return;
    const rlimit now{1, before.rlim_max};  // no file of this process may grow
    setrlimit(RLIMIT_FSIZE, &now);
  };
  std::string said;
  try {
    RunCampaign(Work(10), options);
  } catch (const std::runtime_error& e) {
    said = e.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(said, AllOf(HasSubstr("cannot write"), HasSubstr("; 3 of 10 runs are kept in it, and the same "
                                                               "command goes on from there")));
  EXPECT_EQ(RunCampaign(Work(10), Options("a", 1)).progress.flown, 7);
}

TEST(MissingText, NamesLostPartsInALineAndWhatFliesThem) {
  BatchJob job;
  job.program = "/bin/kestrel";
  job.arguments = {"c.yaml"};
  job.folder = "/shared/c";
  EXPECT_EQ(MissingText(job, {1, 4}, 3),
            "  missing: 2 rows of part 2/3; flown by\n"
            "    /bin/kestrel campaign c.yaml --out /shared/c --shard 2/3 --jobs 1\n");
  EXPECT_EQ(MissingText(job, {1, 4, 5, 6, 11}, 10),
            "  missing: 5 rows of 4 of 10 parts: 2,5-7; flown by Slurm's script, or one after the other, by\n"
            "    sbatch --array=2,5-7 THE_SCRIPT\n"
            "    for I in 2 $(seq 5 7); do /bin/kestrel campaign c.yaml --out /shared/c --shard \"$I/10\" "
            "--jobs 1; done\n");
  EXPECT_EQ(MissingText(job, {3}, 0),
            "  missing: 1 row: 3; flown by\n    /bin/kestrel campaign c.yaml --out /shared/c\n");
}

TEST(Shard, IsReadAndRefused) {
  EXPECT_EQ(ShardOf("3/8").number, 3);
  EXPECT_EQ(ShardOf("3/8").of, 8);
  for (const char* wrong :
       {"", "3", "0/8", "9/8", "1/0", "-1/8", "1/8x", "a/b", "1/", "/2", "1/2/3", "1/100001"})
    EXPECT_THROW(ShardOf(wrong), InputError) << wrong;
  EXPECT_EQ(ShardOfFile("a/results-2-of-5.sqlite")->number, 2);
  EXPECT_FALSE(ShardOfFile("results.sqlite"));
  EXPECT_FALSE(ShardOfFile("results-2-of-5.sqlite-wal"));
  // Every row is of one part.
  for (int row = 0; row < 20; ++row) {
    int parts = 0;
    for (int number = 1; number <= 7; ++number) parts += Shard{number, 7}.Has(row);
    EXPECT_EQ(parts, 1);
  }
}

TEST_F(RunCampaignTest, TheFirstFailuresAndRowsAskedForAreRecordedWhateverTheWorkers) {
  const CampaignWork work = Work({"", "fail", "", "crash", "", "", "", "be refused", "hang", "fail", "fail"});
  for (const int jobs : {1, 3}) {
    CampaignOptions options = Options(fmt::format("{}", jobs), jobs);
    options.record_failures = 3;
    options.record = {6};
    CampaignWork short_work = work;
    short_work.limit_s = 3;
    const CampaignEnd end = RunCampaign(short_work, options);
    EXPECT_EQ(end.recorded, 4);
    EXPECT_THAT(end.mistrust, IsEmpty());
    std::vector<std::int64_t> recorded;
    for (const RunResult& result : ResultStore::Read(options.folder / "results.sqlite").Results()) {
      if (result.execution.recording.empty()) continue;
      recorded.push_back(result.row);
      EXPECT_EQ(result.execution.recording, RecordingFolder(options.folder, result.row));
    }
    EXPECT_THAT(recorded, ElementsAre(1, 3, 4, 6));
    EXPECT_EQ(RunCampaign(short_work, options).recorded, 0);
  }
  CampaignOptions options = Options("more", 1);
  options.record = {11};
  EXPECT_THROW(RunCampaign(work, options), InputError);
}

TEST_F(RunCampaignTest, AScenarioThatChangesUnderWayEndsIt) {
  const fs::path file = folder_ / "flight.yaml";
  std::ofstream(file) << "mission: hover\n";
  CampaignWork work = Work(20);
  work.scenario = file.string();
  CampaignOptions options = Options("a", 1);
  options.show = [&](const Progress& p) {
    if (p.done == 2) std::ofstream(file) << "mission: hover\nduration_s: 3\n";
  };
  try {
    RunCampaign(work, options);
    ADD_FAILURE();
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("flight.yaml was changed while it was flown by"));
  }
  EXPECT_THAT(ResultStore::Read(options.folder / "results.sqlite").Rows().size(), AllOf(Ge(2), Le(4)));
}

TEST_F(RunCampaignTest, ProgressCountsAndARowsLogIsKept) {
  CampaignOptions options = Options("a", 2);
  std::int64_t last = 0;
  options.show = [&](const Progress& p) {
    EXPECT_GE(p.done, last);
    EXPECT_LE(p.counted, p.done);
    last = p.done;
  };
  const CampaignEnd end = RunCampaign(Work({"", "fail", "crash", "", "", "", ""}), options);
  EXPECT_EQ(end.progress.rows, 7);
  EXPECT_EQ(end.progress.done, 7);
  EXPECT_EQ(end.progress.passed, 4);
  EXPECT_EQ(end.progress.counted, 7);
  EXPECT_EQ(end.progress.counted_passed, 4);
  EXPECT_GT(end.progress.Rate(), 0);
  EXPECT_EQ(ResultStore::Read(options.folder / "results.sqlite").Results().at(2).execution.log,
            "row 2 is to crash\n");
}

}  // namespace
}  // namespace kestrel::campaign
