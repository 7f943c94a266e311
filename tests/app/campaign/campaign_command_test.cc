// SPDX-License-Identifier: Apache-2.0
// The verb as people type it, with real flights, and with the engines that fly its parts.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "app/campaign/command_line.h"
#include "base/file/files.h"
#include "base/process/child_process.h"
#include "base/process/shell_word.h"
#include "base/stopwatch.h"
#include "campaign/execution/batch_script.h"
#include "campaign/execution/result_store.h"
#include "tests/campaign/tables.h"
#include "tests/support/content.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A campaign of six flights of half a second, of which some fail.
class CampaignCommandTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    std::ofstream(folder_ / "short.yaml") << R"(scenario: pose
set: [duration_s=0.5, start.settle_s=0.5, "criteria={fix_share: {min: 0.1}, fix_x_rmse_m: {max: 0.03}}"]
runs: 6
vary:
  start.height_m: {uniform: [3, 6]}
  wind.mean_m_s: {uniform: [0, 6]}
)";
  }
  // In the folder.
  Ended Shell(const std::string& command) const { return kestrel::Shell(folder_, command); }
  Ended Campaign(const std::string& arguments) const {
    return Shell(fmt::format("{} campaign {}", KESTREL_PROGRAM, arguments));
  }
  std::string Tables(const std::string& file) const { return campaign::TablesOf(folder_ / file); }
};

TEST_F(CampaignCommandTest, TheSameTableForOneWorkerAndTwoAndAgainByReplay) {
  const Ended one = Campaign("short.yaml --jobs 1 --out one --record-failures 1");
  EXPECT_EQ(one.status, 0) << one.err;
  EXPECT_THAT(one.out, AllOf(HasSubstr("short: 6 of 6 runs"), HasSubstr("one/results.sqlite")));
  EXPECT_THAT(one.err,
              AllOf(HasSubstr("short: 6 of 6 runs, "), Not(HasSubstr("\r"))));  // a log, not a terminal
  const Ended two = Campaign("short.yaml --jobs 2 --out two --record-failures 0");
  EXPECT_EQ(two.status, 0) << two.err;
  const std::string tables = Tables("one/results.sqlite");
  EXPECT_EQ(tables, Tables("two/results.sqlite"));
  // Flights, and different ones.
  const auto results = campaign::ResultStore::Read(folder_ / "one/results.sqlite").Results();
  ASSERT_EQ(results.size(), 6);
  EXPECT_NE(results[0].state_hash, results[1].state_hash);
  EXPECT_TRUE(results[0].metrics.contains("fix_share"));
  EXPECT_GT(results[0].execution.peak_mib, 10);

  const Ended replay = Campaign("replay short.yaml 3 --out one --no-video");
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("the same as the stored result, to the last bit"));
  EXPECT_TRUE(fs::exists(folder_ / "one/recordings/3/telemetry.csv"));

  // Another row under this one's number is told from it.
  const Ended other = Shell(
      "python3 -c \"import sqlite3; db = sqlite3.connect('one/results.sqlite'); db.execute('UPDATE metrics "
      "SET "
      "value = value * (1 + 3e-16) WHERE row = 3'); db.commit()\"");
  EXPECT_EQ(other.status, 0) << other.err;
  const Ended again = Campaign("replay short.yaml 3 --out one --no-video");
  EXPECT_EQ(again.status, 1);
  EXPECT_THAT(again.out, HasSubstr("NOT the same as the stored result"));
}

TEST_F(CampaignCommandTest, AFailureIsRecordedAndTheOthersAreNot) {
  const Ended run = Campaign(
      "short.yaml --jobs 2 --out here --runs 3 --record-failures 1 --set "
      "'set=[duration_s=0.5, start.settle_s=0.5, \"criteria={fix_share: {max: 0}}\"]'");
  EXPECT_EQ(run.status, 1) << run.err;  // a campaign of which none passed, whatever its file asks for
  EXPECT_THAT(run.out, HasSubstr("NOT  runs that passed"));
  EXPECT_THAT(run.out, AllOf(HasSubstr("failed"), HasSubstr("row 0 (failed, completed) is recorded in")));
  EXPECT_TRUE(fs::exists(folder_ / "here/recordings/0/video.mp4"));
  EXPECT_FALSE(fs::exists(folder_ / "here/recordings/1"));
}

TEST_F(CampaignCommandTest, BadInputEndsWithTwoAndSaysWhy) {
  const auto why = [&](const std::string& arguments) {
    const Ended bad = Campaign(arguments);
    EXPECT_EQ(bad.status, 2) << arguments;
    return bad.err;
  };
  EXPECT_THAT(why("short.yaml --shard 7/6"), HasSubstr("--shard: '7/6' is no part of a table"));
  EXPECT_THAT(why("short.yaml --shard 1/6 --stop-when 0.1"), HasSubstr("one of --shard and --stop-when"));
  EXPECT_THAT(why("short.yaml --shard 1/6 --junit j.xml"), HasSubstr("one of --shard and --junit"));
  EXPECT_THAT(why("short.yaml --stop-when 0.1 --set sampling=sobol"), HasSubstr("of a Sobol sequence"));
  for (const char* option : {"--runs", "--seed", "--shard", "--junit"})
    EXPECT_THAT(why(fmt::format("short.yaml {} ''", option)),
                HasSubstr(fmt::format("{}: it is empty", option)));
  EXPECT_THAT(why("shorrt"), HasSubstr("there is no campaign 'shorrt'"));
  EXPECT_THAT(
      why(""),
      HasSubstr("no campaign is named; valid: a campaign's YAML file, or one of\n  attitude/weather "));
  EXPECT_THAT(why("merge short.yaml --out none"),
              HasSubstr("none holds no parts; valid: parts that were flown there before (--shard I/N"));
  EXPECT_THAT(why("replay short.yaml 6"), HasSubstr("there is no row 6; valid: 0 to 5"));
  EXPECT_THAT(why("short.yaml --record 6"), HasSubstr("--record: there is no row 6"));
  why("short.yaml --jobs 0");
  for (const char* width : {"nan", "-nan", "inf", "-0.1", "0.1x"})
    why(fmt::format("short.yaml --stop-when {}", width));
  for (const char* verb : {"", "replay", "merge", "slurm", "report"})
    EXPECT_THAT(why(fmt::format("{} short.yaml --out ''", verb)), HasSubstr("--out: it is empty")) << verb;
  EXPECT_THAT(why("short.yaml --jobs 1.5"),
              HasSubstr("--jobs: '1.5' is not valid; valid: a whole number, 1 to 1024"));
  why("slurm short.yaml");
  std::ofstream(folder_ / "results.sqlite") << std::string(4096, 'x');
  EXPECT_THAT(why("short.yaml --out ."), HasSubstr("it is no SQLite file"));
}

TEST_F(CampaignCommandTest, ReportsOnWhatItFlewByTheThresholdsItWasGiven) {
  fs::create_directories(folder_ / "height");  // not its results, though of its name
  const Ended run = Campaign(
      "height --out here --runs 1 --record-failures 0 --set duration_s=0.5 --set start.settle_s=0.5 "
      "--set 'thresholds={success: {min: 0.999}}'");
  EXPECT_EQ(run.status, 1) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("at least 0.999"), HasSubstr("here/report.html")));
  EXPECT_TRUE(fs::exists(folder_ / "here/report.html"));
  EXPECT_EQ(Campaign("report here").status, 1);
}

// As the workflow of examples/ci does, in a checkout that has no such folder.
TEST_F(CampaignCommandTest, JunitMayLieInTheFolderOfTheResults) {
  const Ended run =
      Campaign("short.yaml --runs 1 --record-failures 0 --out results --junit results/junit.xml");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(fs::exists(folder_ / "results/junit.xml"));
}

TEST_F(CampaignCommandTest, WhatIsThereIsJudgedByAnotherThresholdAndNotFlownAgain) {
  EXPECT_EQ(Campaign("short.yaml --out here --runs 2 --record-failures 0").status, 0);
  std::ofstream(folder_ / "short.yaml", std::ios::app) << "thresholds: {success: {min: 0.999}}\n";
  fs::remove_all(folder_ / "here/logs");
  EXPECT_EQ(Campaign("short.yaml --out here --runs 2 --record-failures 0").status, 1);
  EXPECT_FALSE(fs::exists(folder_ / "here/logs"));  // of a worker
}

TEST_F(CampaignCommandTest, TheFolderOfATuningIsRefused) {
  fs::create_directories(folder_ / "here");
  std::ofstream(folder_ / "here/flights.sqlite") << "";
  const Ended run = Campaign("short.yaml --out here");
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.err, HasSubstr("flights.sqlite is of a tuning, whose report.html would be replaced"));
}

TEST_F(CampaignCommandTest, AnotherTableIsRefusedBeforeAnythingFlies) {
  EXPECT_EQ(Campaign("short.yaml --out here --runs 1 --record-failures 0").status, 0);
  const std::string before = Tables("here/results.sqlite");
  const Ended other = Campaign("short.yaml --out here --runs 2");
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err,
              AllOf(HasSubstr("plan: flown with --runs 1, now with --runs 2"),
                    HasSubstr("table: it is of another"), HasSubstr("valid: another folder (--out)")));
  EXPECT_EQ(Tables("here/results.sqlite"), before);
}

TEST_F(CampaignCommandTest, EndedBeforeAnythingFliesItSaysSo) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const fs::path said = folder_ / "said.txt";
    const pid_t child = fork();
    if (child == 0) {
      if (!std::freopen(said.c_str(), "w", stderr)) _exit(126);
      EndOnInterrupt();
      raise(signal);
      _exit(0);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(WEXITSTATUS(status), 3) << signal;
    EXPECT_THAT(Content(said), HasSubstr("interrupted before anything flew")) << signal;
  }
}

TEST_F(CampaignCommandTest, InterruptedItEndsTheRunsUnderWayAndGoesOn) {
  const auto rows = [&] {
    try {
      return campaign::ResultStore::Read(folder_ / "here/results.sqlite").Rows().size();
    } catch (const std::exception&) {
      return std::size_t{0};
    }
  };
  {
    ChildProcess program({KESTREL_PROGRAM, "campaign", (folder_ / "short.yaml").string(), "--jobs", "1",
                          "--out", (folder_ / "here").string(), "--record-failures", "0"},
                         {}, folder_ / "said.txt");
    const double until_s = MonotonicNow_s() + 60;
    while (rows() < 1 && MonotonicNow_s() < until_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    program.Signal(SIGINT);
    EXPECT_EQ(program.Wait(60), 3) << program.Output();
    EXPECT_THAT(program.Output(), HasSubstr("the same command goes on"));
  }
  const std::size_t kept = rows();
  EXPECT_GE(kept, 1);
  EXPECT_LT(kept, 6);
  EXPECT_EQ(Campaign("short.yaml --jobs 2 --out here --record-failures 0").status, 0);
  EXPECT_EQ(Campaign("short.yaml --jobs 2 --out whole --record-failures 0").status, 0);
  EXPECT_EQ(Tables("here/results.sqlite"), Tables("whole/results.sqlite"));
}

bool IsThere(const std::string& program) {
  return std::system(fmt::format("command -v {} >/dev/null 2>&1", program).c_str()) == 0;
}

TEST(ShellWord, MeansItsText) {
  for (const std::string text :
       {"plain", "a b", "it's", "$HOME `x` \"y\" \\z", "", "a;b|c&d", "*?[]", "{a: [1, 2]}"}) {
    const std::string file = (fs::temp_directory_path() / fmt::format("kestrel_word_{}", getpid())).string();
    ASSERT_EQ(std::system(fmt::format("printf %s {} > {}", ShellWord(text), file).c_str()), 0);
    EXPECT_EQ(Content(file), text);
    fs::remove(file);
  }
}

TEST_F(CampaignCommandTest, PartsByDifferentInstructionSetsAreRefusedAndByOneTheyAreJoined) {
  const std::string part = "short.yaml --runs 2 --jobs 1 --record-failures 0 --out parts ";
  const Ended first = Campaign(part + "--shard 1/2 --isa ssse3");
  ASSERT_EQ(first.status, 0) << first.err;
  const Ended other = Campaign(part + "--shard 2/2");
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, AllOf(HasSubstr("results-1-of-2.sqlite: machine: it was flown on another"),
                               HasSubstr("instruction_set ssse3 and not "), HasSubstr("--isa")));
  const Ended second = Campaign(part + "--shard 2/2 --isa ssse3");
  EXPECT_EQ(second.status, 0) << second.err;
  const Ended merged = Campaign("merge short.yaml --runs 2 --out parts");
  EXPECT_EQ(merged.status, 0) << merged.err;
  EXPECT_THAT(Content(folder_ / "parts/report.html"), HasSubstr("--isa ssse3"));
  const Ended replay = Campaign("replay short.yaml 1 --runs 2 --out parts --no-video --isa ssse3");
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr("the same as the stored result, to the last bit"));
  const Ended otherwise = Campaign("replay short.yaml 1 --runs 2 --out parts --no-video");
  EXPECT_THAT(otherwise.err, HasSubstr("machine: it was flown on another"));
}

TEST_F(CampaignCommandTest, ScriptsFlyByTheInstructionSetThatIsAskedFor) {
  for (const char* verb : {"slurm", "parallel"}) {
    const Ended script = Campaign(fmt::format("{} short.yaml --tasks 2 --out parts --isa ssse3", verb));
    EXPECT_EQ(script.status, 0) << script.err;
    EXPECT_THAT(script.out, HasSubstr("--isa ssse3 --out ")) << verb;
    EXPECT_THAT(Campaign(fmt::format("{} short.yaml --tasks 2 --out parts", verb)).out,
                Not(HasSubstr("--isa")));
  }
}

TEST_F(CampaignCommandTest, GnuParallelFliesItsParts) {
  if (!IsThere("parallel")) GTEST_SKIP() << "there is no GNU parallel here (package parallel)";
  const Ended run = Shell(fmt::format(
      "{} campaign parallel short.yaml --tasks 3 --out 'in parts' > go.sh && sh go.sh", KESTREL_PROGRAM));
  EXPECT_EQ(run.status, 0) << run.err << run.out;
  EXPECT_THAT(run.out, HasSubstr("6 rows from 3 files"));
  EXPECT_EQ(Campaign("short.yaml --jobs 2 --out whole --record-failures 0").status, 0);
  EXPECT_EQ(Tables("in parts/results.sqlite"), Tables("whole/results.sqlite"));
}

// A real Slurm of one node, for as long as this lives.
class SlurmCluster {
 public:
  explicit SlurmCluster(fs::path folder) : folder_(std::move(folder)) { runs_ = Do("start") == 0; }
  ~SlurmCluster() { Do("stop"); }
  bool runs() const { return runs_; }
  std::string conf() const { return (folder_ / "slurm.conf").string(); }

 private:
  int Do(const char* verb) const {
    return std::system(fmt::format("bash {}/tests/app/campaign/slurm_cluster.sh {} {} > {}.log 2>&1",
                                   KESTREL_SOURCE_DIR, verb, folder_.string(), folder_.string())
                           .c_str());
  }
  fs::path folder_;
  bool runs_ = false;
};

TEST_F(CampaignCommandTest, SlurmFliesItsPartsAndALostOneIsNamedAndFlownAgain) {
  for (const char* program : {"slurmctld", "slurmd", "munged", "sbatch"})
    if (!IsThere(program))
      GTEST_SKIP() << "there is no " << program << " here (packages slurmctld, slurmd, slurm-client, munge)";
  if (getuid() != 0) GTEST_SKIP() << "slurmd is root's";
  const SlurmCluster cluster(folder_ / "cluster");
  if (!cluster.runs()) GTEST_SKIP() << "Slurm does not start here: " << Content(folder_ / "cluster.log");

  ASSERT_EQ(Campaign("slurm short.yaml --tasks 3 --out parts > job.sh").status, 0);
  const std::string slurm = "SLURM_CONF=" + cluster.conf() + " ";
  const Ended job = Shell(slurm + "timeout 200 sbatch --wait job.sh");
  EXPECT_EQ(job.status, 0) << job.err << Content(folder_ / "cluster/slurmd.log");
  for (const int number : {1, 2, 3})
    EXPECT_TRUE(fs::exists(folder_ / fmt::format("parts/results-{}-of-3.sqlite", number)));
  fs::remove(folder_ / "parts/results-2-of-3.sqlite");
  const Ended lost = Campaign("merge short.yaml --out parts");
  EXPECT_EQ(lost.status, 1);
  EXPECT_THAT(lost.out, AllOf(HasSubstr("missing: 2 rows of part 2/3; flown by"), HasSubstr("--shard 2/3"),
                              Not(HasSubstr("--shard 1/3"))));
  EXPECT_EQ(Shell(slurm + "timeout 200 sbatch --wait --array=2 job.sh").status, 0);
  const Ended all = Campaign("merge short.yaml --out parts");
  EXPECT_EQ(all.status, 0) << all.err;
  EXPECT_EQ(Campaign("short.yaml --jobs 2 --out whole --record-failures 0").status, 0);
  EXPECT_EQ(Tables("parts/results.sqlite"), Tables("whole/results.sqlite"));
}

}  // namespace
}  // namespace kestrel::app
