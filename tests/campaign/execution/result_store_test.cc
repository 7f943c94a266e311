// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/result_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>

#include "base/yaml/yaml_fields.h"
#include "tests/campaign/results.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// What a shell command prints.
std::string Says(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> bytes;
  for (std::size_t n; (n = std::fread(bytes.data(), 1, bytes.size(), pipe)) > 0;)
    text.append(bytes.data(), n);
  pclose(pipe);
  return text;
}

class ResultStoreTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    file_ = folder_ / "results.sqlite";
  }
  std::string Refusal(const CampaignIdentity& identity) const {
    try {
      ResultStore::Open(file_, identity);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  fs::path file_;
};

bool SameBits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST_F(ResultStoreTest, ReadsBackWhatWasPutToTheLastBit) {
  RunResult result = ResultOf(1);
  result.metrics = {{"third_m", 1.0 / 3},
                    {"least_m", std::numeric_limits<double>::denorm_min()},
                    {"most_m", std::numeric_limits<double>::max()},
                    {"minus_nothing_m", -0.0},
                    {"whole_m", 3},
                    {"endless_m", std::numeric_limits<double>::infinity()},
                    {"none_m", std::numeric_limits<double>::quiet_NaN()}};
  result.status = RunStatus::kBrokeOff;
  result.outcome = "the state is 'no number'\nat 3 s";
  result.execution = {1, 2.5, 0.01, 180.5, "a log\nof two lines", "recordings/1"};
  ResultStore::Open(file_, IdentityOf(TableOf(4))).Put(result);

  const ResultStore store = ResultStore::Read(file_);
  EXPECT_THAT(store.Rows(), ElementsAre(1));
  const RunResult read = store.Results().at(0);
  EXPECT_EQ(read.row, 1);
  EXPECT_EQ(read.status, RunStatus::kBrokeOff);
  EXPECT_EQ(read.outcome, result.outcome);
  EXPECT_EQ(read.state_hash, result.state_hash);
  EXPECT_EQ(read.image_hash, result.image_hash);
  ASSERT_EQ(read.metrics.size(), result.metrics.size());
  for (const auto& [name, value] : result.metrics) {
    if (std::isnan(value)) {
      EXPECT_TRUE(std::isnan(read.metrics.at(name))) << name;
    } else if (value == 0) {  // SQLite knows no sign of it
      EXPECT_EQ(read.metrics.at(name), 0) << name;
    } else {
      EXPECT_TRUE(SameBits(read.metrics.at(name), value)) << name << " " << read.metrics.at(name);
    }
  }
  EXPECT_EQ(read.execution.worker, 1);
  EXPECT_EQ(read.execution.wall_s, 2.5);
  EXPECT_EQ(read.execution.orchestration_s, 0.01);
  EXPECT_EQ(read.execution.peak_mib, 180.5);
  EXPECT_EQ(read.execution.log, "a log\nof two lines");
  EXPECT_EQ(read.execution.recording, "recordings/1");
  const CampaignIdentity wanted = IdentityOf(TableOf(4));
  EXPECT_THAT(Differences(store.identity(), wanted), IsEmpty());
  EXPECT_EQ(store.identity().table.rows, wanted.table.rows);
}

TEST_F(ResultStoreTest, GoesOnWithWhatIsThere) {
  const CampaignIdentity identity = IdentityOf(TableOf(4));
  ResultStore::Open(file_, identity).Put(ResultOf(2));
  ResultStore store = ResultStore::Open(file_, identity);
  EXPECT_THAT(store.Rows(), ElementsAre(2));
  store.Put(ResultOf(0));
  EXPECT_THAT(store.Rows(), ElementsAre(0, 2));
  EXPECT_EQ(store.Results()[0].row, 0);
  EXPECT_EQ(store.Results()[1].metrics, ResultOf(2).metrics);
}

TEST_F(ResultStoreTest, KnowsTheFileOfItsCampaignWhereverThatLies) {
  CampaignIdentity identity = IdentityOf(TableOf(4));
  for (const std::string file : {"/here/gusts.yaml", "/there/gusts.yaml"}) {
    identity.file = file;
    { ResultStore::Open(file_, identity); }
    EXPECT_EQ(ResultStore::Read(file_).identity().file, file);
  }
}

TEST_F(ResultStoreTest, TakesARowOnceAndThoseOfTheTableAlone) {
  ResultStore store = ResultStore::Open(file_, IdentityOf(TableOf(4)));
  store.Put(ResultOf(2));
  EXPECT_THROW(store.Put(ResultOf(2)), std::runtime_error);
  EXPECT_THROW(store.Put(ResultOf(4)), std::runtime_error);
  // All or nothing.
  EXPECT_THROW(store.Put(std::vector{ResultOf(0), ResultOf(1), ResultOf(2)}), std::runtime_error);
  EXPECT_THAT(store.Rows(), ElementsAre(2));
}

TEST_F(ResultStoreTest, ForgetsWhatIsBeyondTheEnd) {
  ResultStore store = ResultStore::Open(file_, IdentityOf(TableOf(4)));
  for (const int row : {0, 3, 1}) store.Put(ResultOf(row));
  store.DropFrom(1);
  EXPECT_THAT(store.Rows(), ElementsAre(0));
  EXPECT_EQ(
      Says("python3 -c \"import sqlite3; db = sqlite3.connect('" + file_.string() +
           "'); print([db.execute('SELECT max(row) FROM ' + t).fetchone()[0] for t in ('runs', 'metrics', "
           "'execution')])\""),
      "[0, 0, 0]\n");
  store.Put(ResultOf(3));
  EXPECT_THAT(store.Rows(), ElementsAre(0, 3));
}

TEST_F(ResultStoreTest, RefusesAnotherCampaignsFileAndSaysWhatDiffers) {
  const CampaignIdentity has = IdentityOf(TableOf(4));
  { ResultStore::Open(file_, has); }
  EXPECT_EQ(Refusal(has), "");
  CampaignIdentity wanted = has;
  wanted.name = "calm";
  EXPECT_THAT(Refusal(wanted),
              AllOf(HasSubstr(file_.string() + ": name: it is of 'gusts', and not of 'calm'"),
                    HasSubstr("valid: another folder (--out)")));
  wanted = has;
  wanted.version = "0.1.0 def";
  EXPECT_THAT(Refusal(wanted), HasSubstr("version: it is of 0.1.0 abc, and this program is 0.1.0 def"));
  wanted = has;
  wanted.plan = "scenario: hover\nruns: 5\n", wanted.table = TableOf(5);
  EXPECT_THAT(Refusal(wanted),
              HasSubstr("plan: it is of another, whose line 2 is 'runs: 4', and not 'runs: 5'"));
  wanted = has;
  wanted.plan += "\n# --set seed=2\n\n# --set set=[a=1]\n", wanted.scenario += "a: 1\n";
  EXPECT_THAT(Refusal(wanted),
              HasSubstr("plan: flown without --seed 2 --set set=[a=1], now with it; valid:"));
  EXPECT_THAT(Differences(wanted, has), Contains("plan: flown with --seed 2 --set set=[a=1], now without"));
  CampaignIdentity other = has;
  other.plan += "\n# --set runs=9\n\n# --set set=[a=1]\n\n# --stop-when 0.02\n";
  EXPECT_THAT(Differences(wanted, other),
              Contains("plan: flown with --seed 2, now with --runs 9 --stop-when 0.02"));
  wanted = has;
  wanted.scenario += "seed: 3\n";
  EXPECT_THAT(Refusal(wanted),
              HasSubstr("scenario: it is of another, whose line 3, 'seed: 3', is not in it"));
  wanted = has;
  wanted.table.rows[2][1] = "0.5";
  EXPECT_THAT(Refusal(wanted), HasSubstr("table: it is of another: row 2: wind.mean_m_s is 0.6666"));
  wanted.table = TableOf(5);
  EXPECT_THAT(Refusal(wanted), HasSubstr("it is of 4 rows, and not 5"));
  wanted.name = "calm";  // all at once
  EXPECT_THAT(Refusal(wanted), AllOf(HasSubstr("name:"), HasSubstr("table:")));
}

TEST_F(ResultStoreTest, RefusesWhatIsNoResultFileAndLeavesItAsItWas) {
  const CampaignIdentity identity = IdentityOf(TableOf(4));
  const std::string text(5000, 'x');
  std::ofstream(file_) << text;
  EXPECT_THAT(Refusal(identity), HasSubstr("it is no SQLite file"));
  EXPECT_THROW(ResultStore::Read(file_), InputError);
  std::ifstream in(file_);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), text);

  fs::remove(file_);
  Says("python3 -c \"import sqlite3; db = sqlite3.connect('" + file_.string() +
       "'); db.execute('CREATE TABLE songs (name)'); db.commit()\"");
  EXPECT_THAT(Refusal(identity), HasSubstr("it is a database of something else"));
  EXPECT_THROW(ResultStore::Read(file_), InputError);
  EXPECT_THROW(ResultStore::Read(folder_ / "none.sqlite"), InputError);
}

// Of what opening it and reading it whole throws.
std::string Damage(const fs::path& file) {
  try {
    ResultStore::Read(file).Results();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST_F(ResultStoreTest, ADamagedFileIsRefusedWithARemedy) {
  const fs::path whole = folder_ / "whole.sqlite", part = folder_ / "results-2-of-8.sqlite";
  const CampaignIdentity identity = IdentityOf(TableOf(300));
  {
    ResultStore store = ResultStore::Open(whole, identity);
    std::vector<RunResult> results;
    for (int row = 0; row < 300; ++row) results.push_back(ResultOf(row));
    store.Put(results);
  }
  const auto size = fs::file_size(whole);
  const std::string remedy = "valid: this file moved out of the way, and its ";
  const auto both = [&](const std::string& what) {
    EXPECT_THAT(Refusal(identity), AllOf(HasSubstr(what), HasSubstr(remedy + "runs flown again")));
    EXPECT_THAT(Damage(file_), AllOf(HasSubstr(what), HasSubstr(remedy + "runs flown again")));
    fs::copy_file(file_, part, fs::copy_options::overwrite_existing);
    EXPECT_THAT(Damage(part), HasSubstr(remedy + "part flown (--shard 2/8) again"));
  };
  fs::copy_file(whole, file_);
  fs::resize_file(file_, size / 2 / 4096 * 4096);
  both(file_.string() + ": it is damaged: ");
  fs::copy_file(whole, file_, fs::copy_options::overwrite_existing);
  {
    std::fstream garbled(file_, std::ios::in | std::ios::out | std::ios::binary);
    garbled.seekp(4096);
    garbled << std::string(static_cast<std::size_t>(size) - 4096, '\x5a');
  }
  both("it is damaged: ");
  const auto sql = [&](const std::string& change) {
    fs::copy_file(whole, file_, fs::copy_options::overwrite_existing);
    Says("python3 -c \"import sqlite3; db = sqlite3.connect('" + file_.string() + "'); db.execute('" +
         change + "'); db.commit()\"");
  };
  sql("DROP TABLE samples");
  both("it is damaged: no such table: samples");
  sql("DELETE FROM samples WHERE row = 7");
  both("it is damaged: its table of samples is not whole");
  sql("UPDATE campaign SET value = 3 WHERE key = \\\"keys\\\"");
  both("it is damaged: the keys of its table are no list of names");
  sql("DROP TABLE metrics");
  both("it is damaged: no such table: metrics");
  sql("DELETE FROM runs WHERE row = 17");
  both("it is damaged: of row 17 it has a part alone");
  sql("UPDATE metrics SET value = \\\"fast\\\" WHERE row = 18");
  both("it is damaged: row 18: its ");
  // What is seen by reading the results alone.
  sql("UPDATE runs SET status = \\\"well\\\" WHERE row = 3");
  EXPECT_THAT(Damage(file_), HasSubstr("it is damaged: row 3: 'well' is no status of a run; " + remedy));
  sql("INSERT INTO runs SELECT 300, status, outcome, state_hash, image_hash FROM runs WHERE row = 299");
  EXPECT_THAT(Damage(file_), HasSubstr("it is damaged: its table has no row 300; " + remedy));
}

TEST_F(ResultStoreTest, GoesOnByAPlanThatJudgesTheSameFlightsOtherwise) {
  CampaignIdentity identity = IdentityOf(TableOf(4));
  ResultStore::Open(file_, identity).Put(ResultOf(2));
  identity.plan += "# a remark\nthresholds: {success: {min: 0.9}}\n";
  EXPECT_THAT(ResultStore::Open(file_, identity).Rows(), ElementsAre(2));
  EXPECT_EQ(ResultStore::Read(file_).identity().plan, identity.plan);
  CampaignIdentity other = identity;
  other.plan += "limit_s: 5\n", other.limit_s = 5;
  EXPECT_THAT(Refusal(other), HasSubstr("plan: it is of another, whose line 5, 'limit_s: 5', is not in it"));
  other = identity;
  other.plan += "\n# --stop-when 0.02\n";
  EXPECT_THAT(Refusal(other), HasSubstr("plan: flown without --stop-when 0.02, now with it"));
}

TEST_F(ResultStoreTest, OfATuningsFlightsThePlanSaysWhatTheyAre) {
  CampaignIdentity identity = IdentityOf(TableOf(4));
  identity.tuning = true;
  { ResultStore::Open(file_, identity); }
  EXPECT_TRUE(ResultStore::Read(file_).identity().tuning);
  EXPECT_THROW(ResultStore::ReadCampaign(file_), InputError);
  EXPECT_THAT(Refusal(IdentityOf(TableOf(4))), HasSubstr("kind: it is of a tuning"));
  identity.plan += "# a remark\n";
  EXPECT_THAT(Refusal(identity), HasSubstr("plan: it is of another"));
}

TEST_F(ResultStoreTest, FlightsByOtherModelsAreOthers) {
  CampaignIdentity identity = IdentityOf(TableOf(4));
  identity.models = "cameras/a.yaml 1\npads/p q.png 2\n";
  { ResultStore::Open(file_, identity); }
  EXPECT_EQ(Refusal(identity), "");
  identity.models = "cameras/a.yaml 1\npads/p q.png 3\nworlds/new.xml 4\n";
  EXPECT_THAT(Refusal(identity), HasSubstr("models: it was flown with another pads/p q.png, worlds/new.xml"));
}

TEST_F(ResultStoreTest, FlightsOnAnotherMachineAreOthers) {
  CampaignIdentity identity = IdentityOf(TableOf(4));
  identity.machine = {{"instruction_set", "avx512"}, {"opencv", "4.6.0 AVX512-SKX"}, {"mujoco", "2.2.2"}};
  { ResultStore::Open(file_, identity); }
  EXPECT_EQ(Refusal(identity), "");
  EXPECT_EQ(ResultStore::Read(file_).identity().machine, identity.machine);
  identity.file = "/elsewhere/gusts.yaml";
  { ResultStore::Open(file_, identity); }
  EXPECT_EQ(ResultStore::Read(file_).identity().machine,
            identity.machine);  // which alone of its origin stays
  identity.machine["instruction_set"] = "avx2", identity.machine["opencv"] = "4.6.0";
  EXPECT_THAT(
      Refusal(identity),
      AllOf(HasSubstr("machine: it was flown on another, with instruction_set avx512 and not avx2, opencv "
                      "4.6.0 AVX512-SKX and not 4.6.0: "),
            HasSubstr("the same --isa"), HasSubstr("valid: another folder (--out)")));
  EXPECT_THAT(DifferencesOf(file_, identity), Contains(HasSubstr("instruction_set avx512 and not avx2")));
}

TEST_F(ResultStoreTest, AnOlderFileIsReadAndItsMachineIsNotKnown) {
  CampaignIdentity identity = IdentityOf(TableOf(4));
  identity.machine = {{"instruction_set", "avx512"}};
  ResultStore::Open(file_, identity).Put(ResultOf(1));
  Says("python3 -c \"import sqlite3; db = sqlite3.connect('" + file_.string() +
       "'); db.execute('DELETE FROM origin WHERE key = \\\"machine\\\"'); db.commit()\"");
  const ResultStore store = ResultStore::Read(file_);
  EXPECT_THAT(store.Rows(), ElementsAre(1));
  EXPECT_THAT(store.identity().machine, IsEmpty());
  EXPECT_THAT(Refusal(identity), HasSubstr("machine: what it was flown on is not known"));
}

TEST_F(ResultStoreTest, HasOneWriter) {
  const CampaignIdentity identity = IdentityOf(TableOf(4));
  const ResultStore store = ResultStore::Open(file_, identity);
  EXPECT_THAT(Refusal(identity), HasSubstr("another process is flying this campaign"));
}

TEST_F(ResultStoreTest, AFolderThatCannotBeWrittenIsTold) {
  EXPECT_THROW(ResultStore::Open(folder_ / "none" / "results.sqlite", IdentityOf(TableOf(1))),
               std::runtime_error);
}

TEST_F(ResultStoreTest, PythonReadsItWhileItIsWritten) {
  ResultStore store = ResultStore::Open(file_, IdentityOf(TableOf(4)));
  const auto python = [&](const std::string& sql) {
    return Says("python3 -c \"import sqlite3; print(sqlite3.connect('file:" + file_.string() +
                "?mode=ro', uri=True).execute('" + sql + "').fetchall())\"");
  };
  EXPECT_EQ(python("SELECT count(*) FROM runs"), "[(0,)]\n");
  RunResult result = ResultOf(2);
  result.metrics["none_m"] = std::numeric_limits<double>::quiet_NaN();
  store.Put(result);
  EXPECT_EQ(python("SELECT row, status, outcome, state_hash FROM runs"),
            "[(2, 'failed', 'completed', '0000000000000002')]\n");
  EXPECT_EQ(python("SELECT name, value FROM metrics ORDER BY name"),
            "[('error_m', 0.9092974268256817), ('none_m', None), ('settle_s', 0.3333333333333333)]\n");
  EXPECT_EQ(python("SELECT value FROM samples WHERE row = 3 ORDER BY key"), "[('10',), ('1',)]\n");
  EXPECT_EQ(
      python("SELECT key FROM campaign ORDER BY key"),
      "[('keys',), ('kind',), ('limit_s',), ('models',), ('name',), ('plan',), ('scenario',), ('schema',), "
      "('table_hash',), ('version',)]\n");
}

TEST_F(ResultStoreTest, AReaderSeesWholeRunsWhileAnotherProcessWrites) {
  constexpr int kRows = 60;
  const CampaignIdentity identity = IdentityOf(TableOf(kRows));
  { ResultStore::Open(file_, identity); }
  const pid_t writer = fork();
  if (writer == 0) {
    ResultStore store = ResultStore::Open(file_, identity);
    for (int row = 0; row < kRows; ++row) store.Put(ResultOf(row));
    _exit(0);
  }
  std::size_t most = 0;
  const ResultStore reader = ResultStore::Read(file_);
  for (bool over = false; !over;) {
    over = waitpid(writer, nullptr, WNOHANG) == writer;
    const auto results = reader.Results();
    EXPECT_GE(results.size(), most);
    most = results.size();
    for (const RunResult& result : results) ASSERT_EQ(result.metrics, ResultOf(result.row).metrics);
  }
  EXPECT_EQ(most, kRows);
}

TEST_F(ResultStoreTest, IsReadWhereNothingCanBeWritten) {
  { ResultStore::Open(file_, IdentityOf(TableOf(4))).Put(ResultOf(1)); }
  ASSERT_FALSE(fs::exists(file_.string() + "-wal"));
  using fs::perms;
  fs::permissions(folder_, perms::owner_read | perms::owner_exec | perms::group_read | perms::group_exec |
                               perms::others_read | perms::others_exec);
  const pid_t reader = fork();
  if (reader == 0) {
    if (getuid() == 0 && setuid(65534) != 0) _exit(2);  // permissions do not hold root back
    try {
      _exit(ResultStore::Read(file_).Rows().size() == 1 ? 0 : 1);
    } catch (const std::exception& e) {
      std::fputs(e.what(), stderr);
      _exit(3);
    }
  }
  int status = 0;
  waitpid(reader, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  fs::permissions(folder_, perms::owner_all);
}

// The process may write no longer files than this: what a full disk is to SQLite, save for the reason.
class NoLongerFiles {
 public:
  explicit NoLongerFiles(std::uintmax_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~NoLongerFiles() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(ResultStoreTest, ADiskThatIsFullStopsItAndWhatIsFinishedStaysReadable) {
  const CampaignIdentity identity = IdentityOf(TableOf(1000));
  ResultStore store = ResultStore::Open(file_, identity);
  int put = 0;
  {
    const NoLongerFiles full(fs::file_size(file_.string() + "-wal") + 60000);
    try {
      for (; put < 1000; ++put) store.Put(ResultOf(put));
    } catch (const std::runtime_error& e) {
      EXPECT_THAT(e.what(), AllOf(HasSubstr("cannot write " + file_.string()), HasSubstr("File too large")));
    }
    EXPECT_GT(put, 0);
    ASSERT_LT(put, 1000);
    EXPECT_EQ(store.Rows().size(), put);
    EXPECT_EQ(ResultStore::Read(file_).Results().size(), put);
  }
  store.Put(ResultOf(put));  // once there is room again
  EXPECT_EQ(ResultStore::Read(file_).Results().size(), put + 1);
}

TEST_F(ResultStoreTest, AFileSystemThatIsFullIsNamed) {
  const fs::path small = folder_ / "small";
  fs::create_directory(small);
  if (mount("kestrel_test", small.c_str(), "tmpfs", 0, "size=300k") != 0)
    GTEST_SKIP() << "no small file system can be mounted here: " << std::strerror(errno);
  int put = 0;
  try {
    ResultStore store = ResultStore::Open(small / "results.sqlite", IdentityOf(TableOf(500)));
    for (; put < 500; ++put) store.Put(ResultOf(put));
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("results.sqlite: the disk is full"));
  }
  EXPECT_LT(put, 500);
  ASSERT_GT(put, 0);
  EXPECT_EQ(ResultStore::Read(small / "results.sqlite").Results().size(), put);
  umount2(small.c_str(), MNT_DETACH);
}

TEST_F(ResultStoreTest, IsReadWhereNoByteIsFree) {
  const fs::path small = folder_ / "small";
  fs::create_directory(small);
  if (mount("kestrel_test", small.c_str(), "tmpfs", 0, "size=300k") != 0)
    GTEST_SKIP() << "no small file system can be mounted here: " << std::strerror(errno);
  const auto fill = [&] {
    std::ofstream filler(small / "filler");
    const std::string page(4096, 'x');
    while (filler.write(page.data(), 4096).flush()) {}
  };
  const fs::path file = small / "results.sqlite";
  { ResultStore::Open(file, IdentityOf(TableOf(4))).Put(ResultOf(1)); }
  fill();
  EXPECT_EQ(ResultStore::Read(file).Results().size(), 1);
  // Likewise what a writer that was killed has left in its log.
  fs::remove(small / "filler");
  const pid_t writer = fork();
  if (writer == 0) {
    ResultStore store = ResultStore::Open(file, IdentityOf(TableOf(4)));
    store.Put(ResultOf(2));
    _exit(0);
  }
  waitpid(writer, nullptr, 0);
  fs::remove(file.string() + "-shm");
  ASSERT_GT(fs::file_size(file.string() + "-wal"), 0);
  fill();
  EXPECT_EQ(ResultStore::Read(file).Results().size(), 2);
  EXPECT_EQ(ResultStore::Read(file).Results().size(), 2);
  umount2(small.c_str(), MNT_DETACH);
}

TEST_F(ResultStoreTest, AProcessThatIsKilledLosesNothingThatPutReturnedFrom) {
  constexpr int kRows = 400;
  const CampaignIdentity identity = IdentityOf(TableOf(kRows));
  std::array<int, 2> told{};
  ASSERT_EQ(pipe(told.data()), 0);
  const pid_t writer = fork();
  if (writer == 0) {
    ResultStore store = ResultStore::Open(file_, identity);
    for (int row = 0; row < kRows; ++row) {
      store.Put(ResultOf(row));
      const char done = 1;
      if (write(told[1], &done, 1) != 1) _exit(1);
    }
    pause();
  }
  close(told[1]);
  char done = 0;
  int put = 0;
  for (; put < 17; ++put) ASSERT_EQ(read(told[0], &done, 1), 1);
  kill(writer, SIGKILL);
  waitpid(writer, nullptr, 0);
  while (read(told[0], &done, 1) == 1) ++put;
  close(told[0]);
  const std::size_t rows = ResultStore::Read(file_).Results().size();
  EXPECT_GE(rows, put);
  EXPECT_LE(rows, put + 1);
  EXPECT_EQ(ResultStore::Open(file_, identity).Rows().size(), rows);  // and its lock is gone with it
}

}  // namespace
}  // namespace kestrel::campaign
