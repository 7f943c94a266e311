// SPDX-License-Identifier: Apache-2.0
#include "app/campaign/campaign_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <tuple>

#include "app/campaign/command_line.h"
#include "app/campaign/progress_log.h"
#include "app/option/command_tree.h"
#include "app/option/within.h"
#include "app/run/isa_option.h"
#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/nearest_name.h"
#include "base/printable.h"
#include "base/process/end_signals.h"
#include "base/process/own_program.h"
#include "base/process/print_note.h"
#include "base/stopwatch.h"
#include "base/user_file.h"
#include "base/yaml/yaml_fields.h"
#include "campaign/counted.h"
#include "campaign/execution/batch_script.h"
#include "campaign/named_file.h"
#include "campaign/statistics/share_sequence.h"
#include "campaign/statistics/stop_rule.h"
#include "campaign/statistics/thresholds.h"
#include "campaign/tuning/flight_cache.h"

namespace kestrel::app {
namespace {

namespace fs = std::filesystem;
using Verb = CampaignArguments::Verb;

std::atomic<int> stop = 0;

// The first interrupt lets the runs under way end; the second, or the request to terminate, does not; after
// that the next ends the program.
void Interrupt(int signal) {
  stop = signal == SIGINT ? stop + 1 : 2;
  if (stop >= 2) EndOnNextSignal();
}

// With an interval that holds however often one looks.
std::string Share(std::int64_t passed, std::int64_t runs) {
  if (runs == 0) return "none flown";
  const Interval interval = campaign::ShareSequence(passed, runs);
  return fmt::format("{:.1f} % passed [{:.1f}, {:.1f}]",
                     100 * static_cast<double>(passed) / static_cast<double>(runs), 100 * interval.low,
                     100 * interval.high);
}

// One line on a terminal, rewritten some times a second.
class ProgressLine {
 public:
  explicit ProgressLine(std::string name) : name_(std::move(name)) {}
  ~ProgressLine() {
    if (shown_) PrintNote("\r\033[K");
  }
  void Show(const campaign::Progress& p) {
    if (shown_ && SecondsSince(last_) < 0.1) return;
    last_ = std::chrono::steady_clock::now();
    shown_ = true;
    PrintNote("\r\033[K{}: {} of {}, {}   {}", name_, p.done, campaign::Counted(p.rows, "run"),
              Share(p.counted_passed, p.counted),
              stop == 1 ? "ending; interrupt again to drop the runs under way" : TimeLeft(p));
    std::fflush(stderr);
  }

 private:
  std::string name_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point last_;
};

// A campaign as the command line asks for it.
struct Asked {
  campaign::LoadedCampaign campaign;
  fs::path folder;
  std::optional<campaign::Shard> shard;
};

Asked Read(const CampaignArguments& a) {
  std::vector<std::string> overrides = a.overrides;
  if (!a.runs.empty()) overrides.push_back("runs=" + a.runs);
  if (!a.seed.empty()) overrides.push_back("seed=" + a.seed);
  Mistakes mistakes;
  // Its folder may be that of the results, which is made with them.
  std::error_code none;
  if (const fs::path folder = fs::path(a.junit).parent_path(); folder.empty() || fs::exists(folder, none))
    CheckWritableFile(a.junit, "--junit", mistakes);
  else
    CheckWritableFolder(folder, "--junit", mistakes);
  const auto attempt = [&](const auto& what) {
    try {
      what();
    } catch (const InputError& e) {
      mistakes.Add(e);
    }
  };
  Asked asked;
  if (!a.shard.empty()) attempt([&] { asked.shard = campaign::ShardOf(a.shard); });
  if (asked.shard && a.stop_when)
    mistakes.Add("--stop-when", "", "a part of a table cannot tell when the whole of it is enough",
                 "valid: one of --shard and --stop-when");
  if (asked.shard && !a.junit.empty())
    mistakes.Add("--junit", "", "a part of a table is not judged",
                 "valid: one of --shard and --junit, the latter once the parts are merged");
  attempt([&] { asked.campaign = campaign::LoadCampaign(CampaignFile(a.file), overrides); });
  const auto& [vary, sampling] = std::tie(asked.campaign.plan.vary, asked.campaign.plan.sampling);
  if (a.stop_when && sampling == "sobol")
    mistakes.Add("--stop-when", "", "the first points of a Sobol sequence are not like the others",
                 "valid: --set sampling=latin_hypercube or independent");
  if (a.stop_when && std::any_of(vary.begin(), vary.end(), [](const auto& each) {
        return std::holds_alternative<campaign::Grid>(each.second);
      }))
    mistakes.Add("--stop-when", "", "the first rows of a grid are not like the others",
                 "valid: a campaign without grids");
  if (mistakes.empty()) {
    asked.folder = a.out.empty() ? fs::path("results/campaigns") / asked.campaign.plan.name : fs::path(a.out);
    CheckWritableFolder(asked.folder, "--out", mistakes);
    RefuseReportOf("tuning", campaign::FlightsFile(asked.folder), mistakes);
  }
  mistakes.ThrowIfAny();
  return asked;
}

// What --stop-when makes of a plan.
std::string RuleOf(const CampaignArguments& a) {
  return a.stop_when ? campaign::StopRule(*a.stop_when) : std::string();
}

// Against the plan's thresholds, also into --junit.
bool KeepsThresholds(const CampaignArguments& a, const Asked& asked,
                     const std::vector<campaign::RunResult>& results) {
  const std::vector<campaign::JudgedThreshold> judged =
      campaign::Judge(asked.campaign.plan.thresholds, results, a.stop_when.has_value());
  if (!a.junit.empty()) {
    if (const fs::path folder = fs::path(a.junit).parent_path(); !folder.empty())
      fs::create_directories(folder);
    WriteFile(a.junit, campaign::ToJunit(asked.campaign.plan.name, judged));
  }
  return std::all_of(judged.begin(), judged.end(),
                     [](const campaign::JudgedThreshold& t) { return t.passed; });
}

bool Fly(const CampaignArguments& a) {
  EndOnInterrupt();
  const Asked asked = Read(a);
  const campaign::CampaignWork work = campaign::WorkOf(asked.campaign, RuleOf(a));
  campaign::CampaignOptions options;
  options.folder = asked.folder;
  options.jobs = a.jobs > 0 ? a.jobs : campaign::Cores();
  options.shard = asked.shard;
  options.record_failures = a.record_failures;
  options.record = a.record;
  options.stop = &stop;
  if (a.stop_when)
    options.enough = [&](const campaign::Progress& p) {
      return campaign::NarrowEnough(p.counted_passed, p.counted, *a.stop_when);
    };
  campaign::CampaignEnd end;
  {
    ProgressLine line(work.identity.name);
    ProgressLog log(work.identity.name);
    if (!a.quiet && isatty(STDERR_FILENO)) options.show = [&](const campaign::Progress& p) { line.Show(p); };
    if (!a.quiet && !isatty(STDERR_FILENO))
      options.show = [&](const campaign::Progress& p) { PrintNote("{}", log.Line(p)); };
    OnEndSignals(Interrupt);
    end = campaign::RunCampaign(work, options);
  }
  const fs::path file = campaign::ResultFile(asked.folder, asked.shard);
  if (!end.Complete())
    throw std::runtime_error(fmt::format("interrupted: {} of {} are kept in {}; the same command goes on",
                                         end.progress.done, campaign::Counted(end.progress.rows, "run"),
                                         file.string()));
  for (const std::string& each : end.mistrust)
    PrintNote("kestrel: flown again it came to something else: {}\n", each);
  if (asked.shard) {
    if (!a.quiet)
      fmt::print("{}, part {}: {}, {}\n  {}\n", work.identity.name, a.shard,
                 campaign::Counted(end.progress.done, "run"), Share(end.progress.passed, end.progress.done),
                 file.string());
    return end.mistrust.empty();
  }
  CampaignReportCommand({.of = a.file, .out = asked.folder.string(), .quiet = a.quiet});
  const std::vector<campaign::RunResult> results = campaign::ResultStore::Read(file).Results();
  if (!a.quiet) {
    fmt::print("{}\n", file.string());
    for (const campaign::RunResult& each : results)
      if (!each.execution.recording.empty())
        fmt::print("row {} ({}, {}) is recorded in {}\n", each.row, campaign::NameOf(each.status),
                   each.outcome, each.execution.recording);
  }
  return KeepsThresholds(a, asked, results) && end.mistrust.empty();
}

bool Replay(const CampaignArguments& a) {
  EndOnInterrupt();
  const Asked asked = Read(a);
  campaign::CampaignWork work = campaign::WorkOf(asked.campaign);
  const auto rows = static_cast<std::int64_t>(work.identity.table.rows.size());
  if (a.row < 0 || a.row >= rows)
    throw InputError("ROW", fmt::format("there is no row {}", a.row),
                     fmt::format("valid: 0 to {}", rows - 1));
  // What is stored of it: by the whole file or a part.
  std::optional<campaign::RunResult> stored;
  std::vector<fs::path> files = campaign::ShardFiles(asked.folder);
  files.insert(files.begin(), campaign::ResultFile(asked.folder));
  for (const fs::path& file : files) {
    if (stored || !IsFile(file)) continue;
    const campaign::ResultStore store = campaign::ResultStore::Read(file);
    for (const campaign::RunResult& result : store.Results())
      if (result.row == a.row) stored = result;
    if (!stored) continue;
    campaign::CampaignIdentity wanted = work.identity;
    wanted.plan = store.identity().plan;  // of which a rule for the end may be a part
    const std::vector<std::string> differences = campaign::Differences(store.identity(), wanted);
    for (const std::string& each : differences) PrintNote("kestrel: {}: {}\n", file.string(), each);
    if (!differences.empty())
      PrintNote(
          "kestrel: row {} is flown with the values that are stored there; scenario and set are the "
          "campaign's as it is now\n",
          a.row);
    work.identity.table = store.identity().table;
  }
  const fs::path folder = campaign::RecordingFolder(asked.folder, a.row);
  campaign::RunOrder order = campaign::OrderFor(work, a.row, folder);
  order.video = !a.no_video;
  if (!a.quiet) fmt::print("row {}: {}\n", a.row, fmt::join(order.overrides, "  "));
  campaign::WorkerPool worker(1, work.limit_s, asked.folder / "logs" / "replay");
  worker.Give(order);
  std::optional<campaign::RunResult> taken;
  while (!taken) taken = worker.WaitForResult(1);
  const campaign::RunResult& flown = *taken;
  if (!a.quiet) {
    fmt::print("  {}: {}\n", campaign::NameOf(flown.status), flown.outcome);
    fmt::print("  state {}  images {}\n  {}\n", flown.state_hash, flown.image_hash, folder.string());
  }
  if (!stored) {
    fmt::print("  there is no stored result to compare it with\n");
    return true;
  }
  const std::string difference = campaign::DifferenceOf(*stored, flown);
  if (difference.empty()) {
    fmt::print("  the same as the stored result, to the last bit: outcome, state, images and {} metrics\n",
               flown.metrics.size());
  } else {
    fmt::print("  NOT the same as the stored result: {}\n", difference);
  }
  return difference.empty();
}

// A newline would end a line of the script, and begin a command.
void RequireNamesWithoutControl(const campaign::BatchJob& job) {
  Mistakes mistakes;
  const auto require = [&](const char* what, const std::string& text) {
    if (HasControl(text))
      mistakes.Add(what, "", fmt::format("'{}' holds a control character, which no script may", text),
                   "valid: another name");
  };
  require("the program", job.program.string());
  require("the working folder", job.directory.string());
  require("the folder of the results", job.folder.string());
  for (const std::string& each : job.environment) require("the environment", each);
  for (const std::string& each : job.arguments) require("the campaign", each);
  mistakes.ThrowIfAny();
}

// A job that this command line, but for its verb, asks for.
campaign::BatchJob JobOf(const CampaignArguments& a, const Asked& asked) {
  campaign::BatchJob job;
  job.name = asked.campaign.plan.name;
  job.program = OwnProgram();
  job.arguments.push_back(fs::absolute(CampaignFile(a.file)).lexically_normal().string());
  for (const std::string& each : a.overrides) job.arguments.insert(job.arguments.end(), {"--set", each});
  if (!a.runs.empty()) job.arguments.insert(job.arguments.end(), {"--runs", a.runs});
  if (!a.seed.empty()) job.arguments.insert(job.arguments.end(), {"--seed", a.seed});
  if (const std::string set = ChosenInstructionSet(); !set.empty())
    job.arguments.insert(job.arguments.end(), {"--isa", set});
  job.folder = fs::absolute(asked.folder).lexically_normal();
  job.directory = fs::current_path();
  for (const char* name : {"KESTREL_ROOT", "KESTREL_PATH", "KESTREL_PLUGINS"})
    if (const char* value = std::getenv(name); value && *value)
      job.environment.push_back(fmt::format("{}={}", name, value));
  job.tasks = a.tasks;
  job.jobs = a.jobs > 0 ? a.jobs : 1;
  RequireNamesWithoutControl(job);
  return job;
}

bool MergeParts(const CampaignArguments& a) {
  const Asked asked = Read(a);
  const campaign::CampaignWork work = campaign::WorkOf(asked.campaign);
  std::vector<fs::path> parts(a.shards.begin(), a.shards.end());
  if (parts.empty()) parts = campaign::ShardFiles(asked.folder);
  if (parts.empty())
    throw InputError("SHARDS", fmt::format("{} holds no parts", asked.folder.string()),
                     "valid: parts that were flown there before (--shard I/N, as by the scripts of slurm and "
                     "parallel), their files by name, or their folder by --out");
  fs::create_directories(asked.folder);
  const fs::path into = campaign::ResultFile(asked.folder);
  const campaign::Merged merged = campaign::Merge(into, work.identity, parts);
  const auto rows = static_cast<std::int64_t>(work.identity.table.rows.size());
  fmt::print("{}: {} rows from {} files, {} were there; {} of {}\n", work.identity.name, merged.added,
             parts.size(), merged.there, rows - static_cast<std::int64_t>(merged.missing.size()), rows);
  fmt::print("  {}\n", into.string());
  if (merged.missing.empty()) return CampaignReportCommand({.of = a.file, .out = asked.folder.string()});

  // Whose they are, if all parts are of one division.
  std::set<int> divisions;
  for (const fs::path& part : parts) {
    const auto shard = campaign::ShardOfFile(part);
    divisions.insert(shard ? shard->of : 0);
  }
  const int of = divisions.size() == 1 ? *divisions.begin() : 0;
  fmt::print("{}", campaign::MissingText(JobOf(a, asked), merged.missing, of));
  return false;
}

bool PrintScript(const CampaignArguments& a) {
  const Asked asked = Read(a);
  const campaign::BatchJob job = JobOf(a, asked);
  fs::create_directories(job.folder / "logs");  // which neither Slurm nor parallel makes
  fmt::print("{}", a.verb == Verb::kSlurm
                       ? campaign::SlurmScript(job)
                       : campaign::ParallelLines(job, std::max(1, campaign::Cores() / job.jobs)));
  return true;
}

// `campaign repot` names no campaign, and was to be `campaign report`.
std::string MeantAsVerb(const CLI::App& command, const std::string& word) {
  const std::vector<std::string> campaigns = campaign::NamesOfKind("campaign");
  const bool is_campaign = IsFile(word) || NearestName(word, campaigns) || fs::path(word).has_extension();
  std::vector<std::string> verbs;
  for (const CLI::App* each : VerbsOf(command)) verbs.push_back(each->get_name());
  const auto near = NearestName(word, verbs);
  if (is_campaign || !near) return {};
  return fmt::format("'{}' is no campaign and no verb; did you mean '{}'?", word, *near);
}

void AddPlanOptions(CLI::App* command, CampaignArguments& a, bool required) {
  command
      ->add_option("file", a.file, "A campaign's YAML file, or the name of one that `list campaigns` shows")
      ->type_name("CAMPAIGN")
      ->required(required);
  command->add_option("--runs", a.runs, "Instead of the file's")->check(NotEmpty);
  command->add_option("--seed", a.seed, "Of the table, instead of the file's")->check(NotEmpty);
  command
      ->add_option(
          "--set", a.overrides,
          "key.path=value, instead of the file's; of a key that only its scenario has, for every run; may be "
          "repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command->add_option("--out", a.out, "Folder of the results (default results/campaigns/NAME)")
      ->type_name("DIR")
      ->check(NotEmpty);
}

}  // namespace

fs::path CampaignFile(const std::string& name_or_file) {
  return campaign::NamedFile("campaign", name_or_file);
}

CLI::App* AddCampaignCommand(CLI::App& app, CampaignArguments& a) {
  CLI::App* command = app.add_subcommand("campaign", "Fly a scenario many times, with what varies in a file");
  AddPlanOptions(command, a, false);
  command->get_option("file")->check(
      [command](const std::string& word) { return MeantAsVerb(*command, word); });
  command->add_option("--jobs", a.jobs, "Worker processes (default: one for each core)")
      ->check(WholeNumber(1, 1024));
  command->add_option("--shard", a.shard, "I/N: fly this part of the table alone, into a file of its own")
      ->check(NotEmpty);
  command
      ->add_option("--stop-when", a.stop_when,
                   "End when the share that passes is known to within this, to either side")
      ->check(NotNan)
      ->check(Within(1e-4, 0.5));
  command
      ->add_option(
          "--record-failures", a.record_failures,
          "Fly the first N of the rows that did not pass again, with video, telemetry and plots; of a "
          "part its share of N, rounded up")
      ->check(WholeNumber(0, 1000000))
      ->capture_default_str();
  command->add_option("--record", a.record, "And this row; may be repeated")->allow_extra_args(false);
  command->add_option("--junit", a.junit, "Also write the thresholds as JUnit XML to this file")
      ->type_name("FILE")
      ->check(NotEmpty);
  command->add_flag("--quiet", a.quiet, "Print nothing but errors");
  command->footer(
      "What was interrupted goes on where it was; after a change of metrics, thresholds or remarks the same "
      "command judges what is there. Records are written of failures alone; any other row is flown again by "
      "replay. Exit status 1: a threshold is not kept.\n\n"
      "A campaign's file has\n"
      "  scenario    a name or a file; set: [KEY=VALUE, ...] for every run\n"
      "  vary        KEY: {uniform: [LOW, HIGH]}, log_uniform likewise, {normal: [MEAN, DEVIATION]},\n"
      "              {truncated_normal: [MEAN, DEVIATION, LOW, HIGH]}, {choice: [...]} or {grid: [...]}\n"
      "  correlated  [{keys: [...], rank_correlation: ...}]\n"
      "  same        [{key: ..., as: ...}]: a key that takes the value of one that varies\n"
      "  sampling    independent, latin_hypercube, sobol\n"
      "  runs, seed  of the table\n"
      "  metrics     those of the tables and of compare; default: those of the scenario's criteria\n"
      "  thresholds  METRIC: {quantile, min, max}; success: {min}\n"
      "  limit_s     of wall time for a run (600)\n\n"
      "Examples:\n"
      "  kestrel campaign dispersion --runs 200\n"
      "  kestrel campaign my_campaign.yaml --jobs 8 --stop-when 0.02\n"
      "  kestrel campaign replay my_campaign.yaml 17\n"
      "  kestrel campaign slurm my_campaign.yaml --tasks 64 > job.sh && sbatch job.sh\n"
      "  kestrel campaign merge my_campaign.yaml");

  const auto verb = [&](const char* name, const char* what, Verb which) {
    CLI::App* sub = command->add_subcommand(name, what);
    AddPlanOptions(sub, a, true);
    sub->callback([&a, which] { a.verb = which; });
    return sub;
  };
  CLI::App* replay =
      verb("replay", "Fly a row again with records, and compare it with its stored result", Verb::kReplay);
  replay->add_option("row", a.row, "From 0")->required();
  replay->add_flag("--no-video", a.no_video, "Do not write video.mp4");
  replay->footer("Example:\n  kestrel campaign replay dispersion 17");
  CLI::App* merge = verb("merge", "Join the results of parts into one file", Verb::kMerge);
  merge->add_option("shards", a.shards, "Result files of parts (default: those in the folder of the results)")
      ->type_name("FILE");
  merge->footer(
      "Once nothing is missing it writes the report. Exit status 1: rows are missing, or a threshold is not "
      "kept.\n\nExample:\n  kestrel campaign merge dispersion --out /shared/dispersion");
  CLI::App* slurm = verb("slurm", "Print an sbatch script that flies the parts as a job array", Verb::kSlurm);
  CLI::App* parallel =
      verb("parallel", "Print the command by which GNU parallel flies the parts", Verb::kParallel);
  for (CLI::App* each : {slurm, parallel}) {
    each->add_option("--tasks", a.tasks, "Parts")->required()->check(WholeNumber(1, 100000));
    each->add_option("--jobs", a.jobs, "Worker processes for each part (default 1)")
        ->check(WholeNumber(1, 1024));
  }
  slurm->footer("Example:\n  kestrel campaign slurm dispersion --tasks 64 > job.sh && sbatch job.sh");
  parallel->footer("Example:\n  kestrel campaign parallel dispersion --tasks 8 | sh");
  AddCampaignReportCommand(*command, a.report)->callback([&a] { a.verb = Verb::kReport; });
  AddCompareCommand(*command, a.compare)->callback([&a] { a.verb = Verb::kCompare; });
  return command;
}

bool CampaignCommand(const CampaignArguments& a) {
  if (a.verb == Verb::kReport) return CampaignReportCommand(a.report);
  if (a.verb == Verb::kCompare) return CompareCommand(a.compare);
  if (a.file.empty()) throw InputError({}, NoneNamed("campaign"));
  switch (a.verb) {
    case Verb::kFly:
      return Fly(a);
    case Verb::kReplay:
      return Replay(a);
    case Verb::kMerge:
      return MergeParts(a);
    case Verb::kSlurm:
    case Verb::kParallel:
      return PrintScript(a);
    case Verb::kReport:
    case Verb::kCompare:
      break;  // above: they have no plan
  }
  return false;
}

}  // namespace kestrel::app
