// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/result_store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/file/writer_lock.h"
#include "base/printable.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/execution/shard.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSchema = "1";
constexpr const char* kTuning = "tuning";
constexpr const char* kMachine = "machine";  // of the table origin
constexpr int kPatience_ms = 60000;          // with who else reads or writes

constexpr const char* kTables = R"(
CREATE TABLE campaign (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE samples (row INTEGER, key TEXT, value TEXT NOT NULL, PRIMARY KEY (row, key)) WITHOUT ROWID;
CREATE TABLE runs (row INTEGER PRIMARY KEY, status TEXT NOT NULL, outcome TEXT NOT NULL,
                   state_hash TEXT NOT NULL, image_hash TEXT NOT NULL);
CREATE TABLE metrics (row INTEGER, name TEXT, value REAL, PRIMARY KEY (row, name)) WITHOUT ROWID;
CREATE TABLE execution (row INTEGER PRIMARY KEY, worker INTEGER, wall_s REAL, orchestration_s REAL,
                        peak_mib REAL, log TEXT, recording TEXT);
CREATE TABLE origin (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
)";

struct SqliteError : std::runtime_error {
  SqliteError(int its_code, const std::string& what) : std::runtime_error(what), code(its_code) {}
  int code;
};

[[noreturn]] void Fail(sqlite3* db, int code) {
  // The system's own word is the better one where a file cannot be read or written.
  const int last = errno;
  const int system = db && sqlite3_system_errno(db) != 0 ? sqlite3_system_errno(db) : last;
  const int base = code & 0xff;
  const bool of_system = base == SQLITE_IOERR || base == SQLITE_CANTOPEN || base == SQLITE_FULL;
  if (base == SQLITE_FULL) throw SqliteError(code, "the disk is full");
  throw SqliteError(code, of_system && system != 0 ? std::strerror(system)
                          : db                     ? sqlite3_errmsg(db)
                                                   : sqlite3_errstr(code));
}

void Do(sqlite3* db, const char* sql) {
  const int code = sqlite3_exec(db, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) Fail(db, code);
}

class Statement {
 public:
  Statement(sqlite3* db, const char* sql) : db_(db) {
    const int code = sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr);
    if (code != SQLITE_OK) Fail(db, code);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // One line of a table.
  template <class... Values>
  void Insert(const Values&... values) {
    int column = 0;
    (Bind(++column, values), ...);
    Next();
    sqlite3_reset(statement_);
  }
  bool Next() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) {
      sqlite3_reset(statement_);
      Fail(db_, code);
    }
    return code == SQLITE_ROW;
  }
  std::int64_t Integer(int column) { return sqlite3_column_int64(statement_, column); }
  double Number(int column) {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL ? std::numeric_limits<double>::quiet_NaN()
                                                                  : sqlite3_column_double(statement_, column);
  }
  // As it may be shown: a file of results may come from anybody.
  std::string Text(int column) {
    const unsigned char* text = sqlite3_column_text(statement_, column);
    if (!text) return {};
    return Printable({reinterpret_cast<const char*>(text),
                      static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))});
  }

 private:
  void Bind(int column, std::int64_t value) { sqlite3_bind_int64(statement_, column, value); }
  void Bind(int column, double value) { sqlite3_bind_double(statement_, column, value); }  // NaN: NULL
  void Bind(int column, const std::string& value) {
    sqlite3_bind_text(statement_, column, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
  }

  sqlite3* db_;
  sqlite3_stmt* statement_ = nullptr;
};

// All of what is done while it lives, or nothing of it.
class Transaction {
 public:
  Transaction(sqlite3* db, const char* begin) : db_(db) { Do(db, begin); }
  ~Transaction() {
    if (!committed_) sqlite3_exec(db_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void Commit() {
    Do(db_, "COMMIT");
    committed_ = true;
  }

 private:
  sqlite3* db_;
  bool committed_ = false;
};

void WriteIdentity(sqlite3* db, const CampaignIdentity& identity) {
  Statement campaign(db, "INSERT INTO campaign VALUES (?, ?)");
  campaign.Insert(std::string("name"), identity.name);
  campaign.Insert(std::string("scenario"), identity.scenario);
  campaign.Insert(std::string("plan"), identity.plan);
  campaign.Insert(std::string("version"), identity.version);
  campaign.Insert(std::string("models"), identity.models);
  campaign.Insert(std::string("limit_s"), fmt::format("{}", identity.limit_s));
  campaign.Insert(std::string("kind"), std::string(identity.tuning ? kTuning : "campaign"));
  campaign.Insert(std::string("table_hash"), HashOf(identity.table));
  campaign.Insert(std::string("keys"), nlohmann::json(identity.table.keys).dump());
  campaign.Insert(std::string("schema"), std::string(kSchema));
  Statement origin(db, "INSERT INTO origin VALUES (?, ?)");
  origin.Insert(std::string("file"), identity.file);
  origin.Insert(std::string(kMachine), nlohmann::json(identity.machine).dump());
  Statement samples(db, "INSERT INTO samples VALUES (?, ?, ?)");
  const SampleTable& table = identity.table;
  for (std::size_t r = 0; r < table.rows.size(); ++r)
    for (std::size_t k = 0; k < table.keys.size(); ++k)
      samples.Insert(static_cast<std::int64_t>(r), table.keys[k], table.rows[r][k]);
}

[[noreturn]] void RefuseAsNone(const fs::path& file, const std::string& why) {
  throw InputError(file.string(), fmt::format("{}", why),
                   "valid: a result file that `kestrel campaign` wrote");
}

[[noreturn]] void RefuseAsDamaged(const fs::path& file, const std::string& why) {
  const auto shard = ShardOfFile(file);
  throw InputError(file.string(), fmt::format("it is damaged: {}", why),
                   fmt::format("valid: this file moved out of the way, and {} again",
                               shard ? fmt::format("its part flown (--shard {}/{})", shard->number, shard->of)
                                     : "its runs flown"));
}

// Whether this is a file's fault, and not the disk's or another process's: no database, one that was cut or
// overwritten, one without its tables.
bool IsDamage(const SqliteError& e) {
  const int code = e.code & 0xff;
  return code == SQLITE_NOTADB || code == SQLITE_CORRUPT || code == SQLITE_ERROR || code == SQLITE_FORMAT ||
         e.code == SQLITE_IOERR_SHORT_READ;
}

[[noreturn]] void Refuse(const fs::path& file, const SqliteError& e) {
  if ((e.code & 0xff) == SQLITE_NOTADB) RefuseAsNone(file, "it is no SQLite file");
  RefuseAsDamaged(file, e.what());
}

std::vector<std::string> KeysIn(const std::string& json, const fs::path& file) {
  try {
    return nlohmann::json::parse(json).get<std::vector<std::string>>();
  } catch (const nlohmann::json::exception&) {
    RefuseAsDamaged(file, "the keys of its table are no list of names");
  }
}

std::map<std::string, std::string> Texts(sqlite3* db, const char* sql) {
  std::map<std::string, std::string> texts;
  for (Statement all(db, sql); all.Next();) texts[all.Text(0)] = all.Text(1);
  return texts;
}

bool HasOrigin(sqlite3* db) {  // which older files do not
  Statement table(db, "SELECT 1 FROM sqlite_master WHERE name = 'origin'");
  return table.Next();
}

// Of `origin`: what depends on where it was flown.
void ReadOrigin(sqlite3* db, const fs::path& file, CampaignIdentity& identity) {
  if (!HasOrigin(db)) return;
  auto texts = Texts(db, "SELECT key, value FROM origin");
  identity.file = texts["file"];
  if (!texts.contains(kMachine)) return;
  try {
    identity.machine = nlohmann::json::parse(texts[kMachine]).get<sim::Machine>();
  } catch (const nlohmann::json::exception&) {
    RefuseAsDamaged(file, "what it says of its machine is no list of names with values");
  }
}

// But for its table, and its origin.
CampaignIdentity IdentityIn(std::map<std::string, std::string>& texts) {
  CampaignIdentity identity{texts["name"], texts["scenario"], texts["plan"], texts["version"], {}};
  identity.models = texts["models"];
  identity.limit_s = std::strtod(texts["limit_s"].c_str(), nullptr);
  identity.tuning = texts["kind"] == kTuning;
  return identity;
}

CampaignIdentity ReadIdentity(sqlite3* db, const fs::path& file) {
  auto texts = Texts(db, "SELECT key, value FROM campaign");
  if (texts["schema"] != kSchema)
    RefuseAsNone(file, fmt::format("its tables are of the schema '{}', and this program knows '{}'",
                                   texts["schema"], kSchema));
  CampaignIdentity identity = IdentityIn(texts);
  ReadOrigin(db, file, identity);
  identity.table.keys = KeysIn(texts["keys"], file);
  std::map<std::string, std::size_t> place;
  for (std::size_t k = 0; k < identity.table.keys.size(); ++k) place[identity.table.keys[k]] = k;
  auto& rows = identity.table.rows;
  for (Statement samples(db, "SELECT row, key, value FROM samples ORDER BY row"); samples.Next();) {
    const auto row = static_cast<std::size_t>(samples.Integer(0));
    const auto found = place.find(samples.Text(1));
    if (row > rows.size() || found == place.end()) RefuseAsDamaged(file, "its table of samples is not whole");
    if (row == rows.size()) rows.emplace_back(identity.table.keys.size());
    rows[row][found->second] = samples.Text(2);
  }
  if (HashOf(identity.table) != texts["table_hash"])
    RefuseAsDamaged(file, "its table of samples is not what its hash says");
  return identity;
}

// Whether there is a campaign in it; another database is refused.
bool HasTables(sqlite3* db, const fs::path& file) {
  Statement all(db, "SELECT count(*), sum(name = 'campaign') FROM sqlite_master WHERE type = 'table'");
  all.Next();
  if (all.Integer(0) > 0 && all.Integer(1) == 0) RefuseAsNone(file, "it is a database of something else");
  return all.Integer(0) > 0;
}

// What is written of a run is written at once.
void RequireWholeRuns(sqlite3* db, const fs::path& file) {
  Statement stray(db,
                  "SELECT row FROM (SELECT row FROM metrics UNION SELECT row FROM execution) "
                  "WHERE row NOT IN (SELECT row FROM runs)");
  if (stray.Next()) RefuseAsDamaged(file, fmt::format("of row {} it has a part alone", stray.Integer(0)));
  Statement words(db, "SELECT row, name FROM metrics WHERE typeof(value) NOT IN ('real', 'integer', 'null')");
  if (words.Next())
    RefuseAsDamaged(file, fmt::format("row {}: its {} is no number", words.Integer(0), words.Text(1)));
}

// The name by which SQLite reads what is in a file, without its log, and touches nothing.
std::string AtRest(const fs::path& file) {
  std::string name = "file:";
  for (const char c : fs::absolute(file).string())
    name += c == '?' || c == '#' || c == '%' ? fmt::format("%{:02X}", c) : std::string(1, c);
  return name + "?immutable=1";
}

}  // namespace

std::vector<std::string> DifferencesOf(const fs::path& file, const CampaignIdentity& wanted) {
  sqlite3* db = nullptr;
  std::vector<std::string> differences;
  try {
    const int code =
        sqlite3_open_v2(AtRest(file).c_str(), &db, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    if (code != SQLITE_OK) Fail(db, code);
    auto texts = Texts(db, "SELECT key, value FROM campaign");
    CampaignIdentity without_rows = wanted;
    without_rows.table = {};
    const bool same_table = texts["table_hash"] == HashOf(wanted.table);
    CampaignIdentity has = IdentityIn(texts);
    ReadOrigin(db, file, has);
    differences = Differences(has, without_rows, same_table);
    if (!same_table) differences.push_back("table: it is of another");
  } catch (const SqliteError&) {
    differences.clear();
  }
  sqlite3_close(db);
  return differences;
}

struct ResultStore::Database {
  fs::path file;
  sqlite3* handle = nullptr;
  std::optional<WriterLock> lock;
  CampaignIdentity identity;

  ~Database() { sqlite3_close(handle); }
  void OpenFile(const std::string& name, int flags) {
    const int code = sqlite3_open_v2(name.c_str(), &handle, flags, nullptr);
    if (code != SQLITE_OK) Fail(handle, code);
    sqlite3_extended_result_codes(handle, 1);
    sqlite3_busy_timeout(handle, kPatience_ms);
  }
  void Lock() {
    lock.emplace(
        file.string() + "-lock",
        fmt::format(
            "{}: another process is flying this campaign; valid: to let it end, or another folder (--out)",
            file.string()));
  }
  [[noreturn]] void CannotWrite(const SqliteError& e) const {
    if (IsDamage(e)) Refuse(file, e);
    throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(), e.what()));
  }
  [[noreturn]] void CannotRead(const SqliteError& e) const {
    if (IsDamage(e)) Refuse(file, e);
    throw std::runtime_error(fmt::format("cannot read {}: {}", file.string(), e.what()));
  }
};

ResultStore::ResultStore(std::unique_ptr<Database> database) : database_(std::move(database)) {}
ResultStore::~ResultStore() = default;
ResultStore::ResultStore(ResultStore&&) noexcept = default;

ResultStore ResultStore::Open(const fs::path& file, const CampaignIdentity& identity) {
  auto database = std::make_unique<Database>();
  database->file = file;
  database->Lock();
  try {
    database->OpenFile(file.string(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
    sqlite3* db = database->handle;
    const bool there = HasTables(db, file);
    Do(db, "PRAGMA journal_mode = WAL");
    Do(db, "PRAGMA synchronous = FULL");
    if (there) {
      database->identity = ReadIdentity(db, file);
      RequireWholeRuns(db, file);
      const auto differences = Differences(database->identity, identity);
      if (!differences.empty()) {
        Mistakes mistakes;
        for (const std::string& each : differences)
          mistakes.Add(file.string(), "", each,
                       "valid: another folder (--out), or this file moved out of the way");
        mistakes.ThrowIfAny();
      }
    } else {
      Transaction all(db, "BEGIN IMMEDIATE");
      Do(db, kTables);
      WriteIdentity(db, identity);
      all.Commit();
      database->identity = identity;
    }
    if (database->identity.file != identity.file && HasOrigin(db))
      Statement(db, "UPDATE origin SET value = ? WHERE key = 'file'").Insert(identity.file);
    if (database->identity.plan != identity.plan)
      Statement(db, "UPDATE campaign SET value = ? WHERE key = 'plan'").Insert(identity.plan);
    database->identity.file = identity.file, database->identity.plan = identity.plan;
  } catch (const SqliteError& e) {
    database->CannotWrite(e);
  }
  return ResultStore(std::move(database));
}

ResultStore ResultStore::ReadCampaign(const fs::path& file) {
  ResultStore store = Read(file);
  if (store.identity().tuning)
    throw InputError(file.string(), "it holds the flights of a tuning, each by gains of its own",
                     "valid: the results of a campaign. A tuning's report is written by the same `kestrel "
                     "tune` again, which flies nothing anew");
  return store;
}

ResultStore ResultStore::Read(const fs::path& file) {
  std::error_code none;
  if (!fs::is_regular_file(file, none))
    RefuseAsNone(file, fs::exists(file, none) ? "it is no regular file" : "there is no such file");
  const auto read = [&](const std::string& name, int flags, bool alone = false) {
    auto database = std::make_unique<Database>();
    database->file = file;
    database->OpenFile(name, flags);
    if (alone) {
      Do(database->handle, "PRAGMA locking_mode = EXCLUSIVE");  // the log's index is in memory then
      sqlite3_db_config(database->handle, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
    }
    Do(database->handle, "PRAGMA query_only = ON");
    if (!HasTables(database->handle, file)) RefuseAsNone(file, "it is empty");
    database->identity = ReadIdentity(database->handle, file);
    RequireWholeRuns(database->handle, file);
    return ResultStore(std::move(database));
  };
  try {
    try {
      // The log of a writer that was killed is put in order by its first reader, who must be able to write.
      return read(file.string(), SQLITE_OPEN_READWRITE);
    } catch (const SqliteError& e) {
      // Where nothing can be written, or no room is left, not even for the log's index, nobody else writes
      // either.
      const int code = e.code & 0xff;
      const bool no_room = code == SQLITE_IOERR || code == SQLITE_FULL;
      if (IsDamage(e) || (!no_room && code != SQLITE_CANTOPEN && code != SQLITE_READONLY)) throw;
      if (!fs::exists(file.string() + "-wal", none))
        return read(AtRest(file), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
      if (!no_room) throw;
      return read(file.string(), SQLITE_OPEN_READWRITE, true);
    }
  } catch (const SqliteError& e) {
    if (IsDamage(e)) Refuse(file, e);
    throw std::runtime_error(fmt::format("cannot read {}: {}", file.string(), e.what()));
  }
}

const CampaignIdentity& ResultStore::identity() const { return database_->identity; }

void ResultStore::Put(const RunResult& result) { Put(std::vector<RunResult>{result}); }

void ResultStore::Put(const std::vector<RunResult>& results) {
  sqlite3* db = database_->handle;
  std::int64_t row = 0;
  try {
    Transaction all(db, "BEGIN IMMEDIATE");
    Statement runs(db, "INSERT INTO runs VALUES (?, ?, ?, ?, ?)");
    Statement metrics(db, "INSERT INTO metrics VALUES (?, ?, ?)");
    Statement execution(db, "INSERT INTO execution VALUES (?, ?, ?, ?, ?, ?, ?)");
    for (const RunResult& r : results) {
      row = r.row;
      if (row < 0 || row >= static_cast<std::int64_t>(database_->identity.table.rows.size()))
        throw std::runtime_error(fmt::format("{}: there is no row {}", database_->file.string(), row));
      runs.Insert(row, std::string(NameOf(r.status)), r.outcome, r.state_hash, r.image_hash);
      for (const auto& [name, value] : r.metrics) metrics.Insert(row, name, value);
      const RunResult::Execution& e = r.execution;
      execution.Insert(row, static_cast<std::int64_t>(e.worker), e.wall_s, e.orchestration_s, e.peak_mib,
                       e.log, e.recording);
    }
    all.Commit();
  } catch (const SqliteError& e) {
    if ((e.code & 0xff) == SQLITE_CONSTRAINT)
      throw std::runtime_error(fmt::format("{}: row {} has a result already", database_->file.string(), row));
    database_->CannotWrite(e);
  }
}

void ResultStore::SetRecording(std::int64_t row, const std::string& folder) {
  try {
    Statement(database_->handle, "UPDATE execution SET recording = ? WHERE row = ?").Insert(folder, row);
  } catch (const SqliteError& e) {
    database_->CannotWrite(e);
  }
}

void ResultStore::DropFrom(std::int64_t row) {
  sqlite3* db = database_->handle;
  try {
    Transaction all(db, "BEGIN IMMEDIATE");
    for (const char* sql : {"DELETE FROM runs WHERE row >= ?", "DELETE FROM metrics WHERE row >= ?",
                            "DELETE FROM execution WHERE row >= ?"})
      Statement(db, sql).Insert(row);
    all.Commit();
  } catch (const SqliteError& e) {
    database_->CannotWrite(e);
  }
}

std::set<std::int64_t> ResultStore::Rows() const {
  try {
    std::set<std::int64_t> rows;
    for (Statement runs(database_->handle, "SELECT row FROM runs"); runs.Next();)
      rows.insert(runs.Integer(0));
    return rows;
  } catch (const SqliteError& e) {
    database_->CannotRead(e);
  }
}

std::vector<RunResult> ResultStore::Results() const {
  sqlite3* db = database_->handle;
  try {
    std::vector<RunResult> results;
    // The runs and the metrics of one moment, whatever is written meanwhile.
    Transaction moment(db, "BEGIN");
    Statement runs(
        db,
        "SELECT runs.row, status, outcome, state_hash, image_hash, worker, wall_s, orchestration_s,"
        " peak_mib, log, recording FROM runs LEFT JOIN execution ON execution.row = runs.row"
        " ORDER BY runs.row");
    while (runs.Next()) {
      RunResult& r = results.emplace_back();
      r.row = runs.Integer(0);
      if (r.row < 0 || r.row >= static_cast<std::int64_t>(database_->identity.table.rows.size()))
        RefuseAsDamaged(database_->file, fmt::format("its table has no row {}", r.row));
      try {
        r.status = RunStatusOf(runs.Text(1));
      } catch (const std::runtime_error& e) {
        RefuseAsDamaged(database_->file, fmt::format("row {}: {}", r.row, e.what()));
      }
      r.outcome = runs.Text(2), r.state_hash = runs.Text(3), r.image_hash = runs.Text(4);
      r.execution = {static_cast<int>(runs.Integer(5)),
                     runs.Number(6),
                     runs.Number(7),
                     runs.Number(8),
                     runs.Text(9),
                     runs.Text(10)};
    }
    Statement metrics(db, "SELECT row, name, value FROM metrics ORDER BY row, name");
    std::size_t at = 0;
    while (metrics.Next()) {
      while (at < results.size() && results[at].row < metrics.Integer(0)) ++at;
      if (at < results.size() && results[at].row == metrics.Integer(0))
        results[at].metrics[metrics.Text(1)] = metrics.Number(2);
    }
    return results;
  } catch (const SqliteError& e) {
    database_->CannotRead(e);
  }
}

}  // namespace kestrel::campaign
