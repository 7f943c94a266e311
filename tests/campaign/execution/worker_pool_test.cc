// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/worker_pool.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <thread>

#include "base/stopwatch.h"
#include "base/version.h"
#include "campaign/execution/worker_wire.h"
#include "tests/campaign/scripted_worker.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr double kPatience_s = 60;  // on a loaded machine

RunOrder Order(std::int64_t row, const std::string& what = "") {
  return {row, "hover", {"seed=1", "do=" + what}, std::nullopt, false};
}

class WorkerPoolTest : public InTemporaryFolder {
 protected:
  WorkerPool Pool(int workers, double limit_s = kPatience_s) const {
    return WorkerPool(workers, limit_s, folder_ / "logs", ScriptedWorker(folder_));
  }
  // All of these, by row.
  static std::map<std::int64_t, RunResult> Fly(WorkerPool& pool, std::vector<RunOrder> orders) {
    std::map<std::int64_t, RunResult> results;
    const double until_s = MonotonicNow_s() + kPatience_s;
    for (std::size_t given = 0; MonotonicNow_s() < until_s;) {
      while (given < orders.size() && pool.Idle()) pool.Give(orders[given++]);
      if (pool.under_way() == 0) break;
      if (const auto result = pool.WaitForResult(1)) {
        EXPECT_TRUE(results.emplace(result->row, *result).second) << "row " << result->row << " came twice";
      }
    }
    return results;
  }
};

TEST(WorkerWire, NumbersAndTextsComeThroughToTheLastBit) {
  RunResult result;
  result.row = 1LL << 40;
  result.status = RunStatus::kBrokeOff;
  result.outcome = "two\nlines and a \"word\", \xff";
  result.metrics = {{"third", 1.0 / 3},
                    {"least", std::numeric_limits<double>::denorm_min()},
                    {"most", -std::numeric_limits<double>::max()},
                    {"nothing", -0.0},
                    {"endless", -std::numeric_limits<double>::infinity()},
                    {"none", std::numeric_limits<double>::quiet_NaN()}};
  for (int i = 0; i < 1000; ++i)
    result.metrics[fmt::format("sine {}", i)] = std::sin(i * 1e5) * std::exp2(i - 500);
  result.state_hash = "00ff", result.image_hash = "ff00";
  result.execution.wall_s = 0.1, result.execution.peak_mib = 1e3 / 7;
  std::string line = ReportLine(result);
  ASSERT_EQ(line.find('\n'), line.size() - 1);
  line.pop_back();
  const RunResult read = ReportOf(line);
  EXPECT_EQ(read.row, result.row);
  EXPECT_EQ(read.status, result.status);
  EXPECT_THAT(read.outcome, HasSubstr("two\nlines and a \"word\", "));
  ASSERT_EQ(read.metrics.size(), result.metrics.size());
  for (const auto& [name, value] : result.metrics) {
    const double back = read.metrics.at(name);
    EXPECT_TRUE(std::memcmp(&value, &back, sizeof value) == 0 || (std::isnan(value) && std::isnan(back)))
        << name;
  }
  EXPECT_EQ(read.state_hash, "00ff");
  EXPECT_EQ(read.execution.wall_s, 0.1);
  EXPECT_EQ(read.execution.peak_mib, 1e3 / 7);

  const RunOrder order{3, "a b.yaml", {"wind.mean_m_s=0.1", "name=\"x\""}, fs::path("out/3"), true};
  std::string words = OrderLine(order);
  words.pop_back();
  const RunOrder back = OrderOf(words);
  EXPECT_EQ(back.row, 3);
  EXPECT_EQ(back.scenario, order.scenario);
  EXPECT_EQ(back.overrides, order.overrides);
  EXPECT_EQ(back.folder, order.folder);
  EXPECT_TRUE(back.video);
}

TEST(WorkerWire, WhatIsNoReportIsRefused) {
  for (const char* line :
       {"", "I saw a bird", "{}", "[1]", R"({"row": "x"})", R"({"row":1,"status":"flew"})"})
    EXPECT_THROW(ReportOf(line), std::runtime_error) << line;
  EXPECT_THROW(OrderOf("{}"), std::runtime_error);
  EXPECT_FALSE(IsGreeting("{}"));
  EXPECT_FALSE(IsGreeting("ready"));
}

TEST_F(WorkerPoolTest, FliesAllThatIsGivenOnceEach) {
  WorkerPool pool = Pool(3);
  EXPECT_TRUE(pool.Idle());
  std::vector<RunOrder> orders;
  for (int row = 0; row < 40; ++row) orders.push_back(Order(row));
  const auto results = Fly(pool, orders);
  ASSERT_EQ(results.size(), 40);
  for (const auto& [row, result] : results) {
    EXPECT_EQ(result.status, row % 5 == 4 ? RunStatus::kFailed : RunStatus::kPassed);
    EXPECT_NEAR(result.metrics.at("error_m"), std::sin(static_cast<double>(row)), 1e-15);
    EXPECT_TRUE(std::isnan(result.metrics.at("none")));
    // Of the time since it was given, 0.25 s were of the flight by what the worker says.
    EXPECT_NEAR(result.execution.wall_s - result.execution.orchestration_s, 0.25, 1e-12);
    EXPECT_EQ(result.execution.peak_mib, 12.5);
  }
  auto flown = RowsIn(folder_ / "flown.txt");
  EXPECT_EQ(flown.size(), 40);
  EXPECT_EQ(pool.under_way(), 0);
  EXPECT_FALSE(pool.WaitForResult(0));
}

TEST_F(WorkerPoolTest, ACrashCostsItsOwnRunAloneAndIsNamedWithItsLog) {
  WorkerPool pool = Pool(2);
  const auto results =
      Fly(pool, {Order(0), Order(1, "crash"), Order(2), Order(3, "exit"), Order(5), Order(6)});
  ASSERT_EQ(results.size(), 6);
  for (const int row : {0, 2, 5, 6}) EXPECT_EQ(results.at(row).status, RunStatus::kPassed) << row;
  const RunResult& crash = results.at(1);
  EXPECT_EQ(crash.status, RunStatus::kCrashed);
  EXPECT_EQ(crash.outcome, "killed by SIGSEGV (Segmentation fault)");
  EXPECT_EQ(crash.execution.log, "row 1 is to crash\n");
  EXPECT_THAT(crash.metrics, IsEmpty());
  EXPECT_EQ(results.at(3).status, RunStatus::kCrashed);
  EXPECT_EQ(results.at(3).outcome, "ended with status 7");
}

TEST_F(WorkerPoolTest, ACrashThatIsNotTheRowsDoingIsFlownAgain) {
  WorkerPool pool = Pool(2);
  const auto results = Fly(pool, {Order(0, "crash once"), Order(1, "be killed once"), Order(2)});
  ASSERT_EQ(results.size(), 3);
  for (const auto& [row, result] : results) EXPECT_EQ(result.status, RunStatus::kPassed) << row;
  EXPECT_THAT(RowsIn(folder_ / "given.txt"), UnorderedElementsAre(0, 0, 1, 1, 2));
}

TEST_F(WorkerPoolTest, ARowWhoseWorkersAreAlwaysKilledHasCrashed) {
  WorkerPool pool = Pool(1);
  const auto results = Fly(pool, {Order(0, "be killed")});
  EXPECT_EQ(results.at(0).status, RunStatus::kCrashed);
  EXPECT_EQ(results.at(0).outcome, "killed by SIGKILL (Killed)");
}

TEST_F(WorkerPoolTest, ARunThatHangsIsEndedAtItsLimit) {
  WorkerPool pool = Pool(2, 2);
  const double start_s = MonotonicNow_s();
  const auto results = Fly(pool, {Order(0, "hang"), Order(1), Order(2), Order(3)});
  ASSERT_EQ(results.size(), 4);
  EXPECT_EQ(results.at(0).status, RunStatus::kTimedOut);
  EXPECT_EQ(results.at(0).outcome, "took longer than the 2 s of wall time that it may");
  EXPECT_EQ(results.at(0).execution.log, "row 0 is to hang\n");
  EXPECT_GE(MonotonicNow_s() - start_s, 2);
  EXPECT_GE(results.at(0).execution.wall_s, 2);
  for (const int row : {1, 2, 3}) EXPECT_EQ(results.at(row).status, RunStatus::kPassed);
  EXPECT_EQ(Fly(pool, {Order(5), Order(6)}).size(), 2);  // both workers work on
}

TEST_F(WorkerPoolTest, WhatIsNoReportCountsAsACrash) {
  WorkerPool pool = Pool(1);
  const auto results = Fly(pool, {Order(0, "babble"), Order(1), Order(2, "take another"), Order(3)});
  ASSERT_EQ(results.size(), 4);
  EXPECT_EQ(results.at(0).status, RunStatus::kCrashed);
  EXPECT_THAT(results.at(0).outcome, HasSubstr("'I saw a bird' is none of the wire's lines"));
  EXPECT_EQ(results.at(2).status, RunStatus::kCrashed);
  EXPECT_THAT(results.at(2).outcome, HasSubstr("reported row 1002"));
  EXPECT_EQ(results.at(1).status, RunStatus::kPassed);
  EXPECT_EQ(results.at(3).status, RunStatus::kPassed);
}

TEST_F(WorkerPoolTest, ABrokenOffAndARefusedRunKeepTheirLog) {
  WorkerPool pool = Pool(1);
  const auto results = Fly(pool, {Order(0, "break off"), Order(1, "be refused"), Order(2, "fail")});
  EXPECT_EQ(results.at(0).status, RunStatus::kBrokeOff);
  EXPECT_EQ(results.at(0).execution.log, "row 0 is to break off\n");
  EXPECT_EQ(results.at(1).status, RunStatus::kRefused);
  EXPECT_EQ(results.at(1).execution.log, "row 1 is to be refused\n");
  EXPECT_EQ(results.at(2).status, RunStatus::kFailed);
  EXPECT_EQ(results.at(2).execution.log, "");
}

TEST_F(WorkerPoolTest, ProgramsThatCannotFlyEndItWithTheReason) {
  const auto why = [&](const std::vector<std::string>& command) -> std::string {
    try {
      WorkerPool pool(1, kPatience_s, folder_ / "logs", command);
      pool.Give(Order(0));
      while (!pool.WaitForResult(1)) {}
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(why({"/nonexistent/kestrel"}), HasSubstr("/nonexistent/kestrel: No such file or directory"));
  EXPECT_THAT(why({"/bin/sh", "-c", "echo a library is missing >&2; exit 5"}),
              ::testing::AllOf(HasSubstr("workers cannot be started"), HasSubstr("ended with status 5"),
                               HasSubstr("a library is missing")));
  EXPECT_THAT(why({"/bin/echo", "hello"}), HasSubstr("'hello' is none of the wire's lines"));
  EXPECT_THAT(why({KESTREL_WORKER, "0.0 of another build"}),
              ::testing::AllOf(HasSubstr("ended with status 2"), HasSubstr("of the same version"),
                               HasSubstr(Version())));
}

// Whether a process is there and no zombie.
bool Lives(pid_t process) {
  std::ifstream in(fmt::format("/proc/{}/stat", process));
  std::string number, name, state;
  return (in >> number >> name >> state) && state != "Z";
}

// By the kernel's own list.
std::vector<pid_t> ChildrenOf(pid_t parent) {
  std::vector<pid_t> children;
  std::ifstream in(fmt::format("/proc/{0}/task/{0}/children", parent));
  for (pid_t each; in >> each;)
    if (Lives(each)) children.push_back(each);
  return children;
}

TEST_F(WorkerPoolTest, WorkersEndWithTheParentWhateverItsEnd) {
  const pid_t parent = fork();
  if (parent == 0) {
    try {
      WorkerPool pool = Pool(2);
      pool.Give(Order(0, "hang"));
      pool.Give(Order(1, "hang"));
      while (RowsIn(folder_ / "given.txt").size() < 2) pool.WaitForResult(0.01);
      std::ofstream(folder_ / "under_way") << "yes";
      for (;;) pool.WaitForResult(1);
    } catch (const std::exception& e) {
      std::fputs(e.what(), stderr);
      _exit(1);
    }
  }
  const double until_s = MonotonicNow_s() + kPatience_s;
  while (!fs::exists(folder_ / "under_way") && MonotonicNow_s() < until_s)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const std::vector<pid_t> workers = ChildrenOf(parent);
  ASSERT_EQ(workers.size(), 2);
  for (const pid_t each : workers) EXPECT_TRUE(Lives(each));
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  for (const pid_t each : workers) {
    while (Lives(each) && MonotonicNow_s() < until_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_FALSE(Lives(each));
  }
}

TEST_F(WorkerPoolTest, ThePoolEndsItsWorkersWithItself) {
  std::vector<pid_t> workers;
  {
    WorkerPool pool = Pool(2);
    pool.Give(Order(0, "hang"));
    workers = ChildrenOf(getpid());
    ASSERT_EQ(workers.size(), 2);
  }
  for (const pid_t each : workers) EXPECT_FALSE(Lives(each));
}

}  // namespace
}  // namespace kestrel::campaign
