// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/batch_script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "base/process/shell_word.h"

namespace kestrel::campaign {
namespace {

std::string Program(const BatchJob& job) {
  std::string program = ShellWord(job.program.string()) + " campaign", environment;
  for (const std::string& each : job.environment) environment += ' ' + ShellWord(each);
  return environment.empty() ? program : fmt::format("env{} {}", environment, program);
}

std::string Arguments(const BatchJob& job) {
  std::string all;
  for (const std::string& each : job.arguments) all += fmt::format(" {}", ShellWord(each));
  return all + fmt::format(" --out {}", ShellWord(job.folder.string()));
}

std::vector<std::pair<std::int64_t, std::int64_t>> RangesOf(const std::set<std::int64_t>& numbers) {
  std::vector<std::pair<std::int64_t, std::int64_t>> ranges;
  for (const std::int64_t n : numbers) {
    if (!ranges.empty() && ranges.back().second == n - 1)
      ranges.back().second = n;
    else
      ranges.push_back({n, n});
  }
  return ranges;
}

}  // namespace

std::string FlyCommand(const BatchJob& job) { return Program(job) + Arguments(job); }

std::string ShardCommand(const BatchJob& job, const std::string& shard) {
  return fmt::format("{} --shard {} --jobs {}", FlyCommand(job), shard, job.jobs);
}

std::string MergeCommand(const BatchJob& job) {
  return fmt::format("{} merge{}", Program(job), Arguments(job));
}

std::string SlurmScript(const BatchJob& job) {
  const std::string log = (job.folder / "logs" / "slurm-%A_%a.log").string();
  return fmt::format(R"(#!/bin/bash
# Flies a campaign in {0} parts:   sbatch THIS_FILE
# then joins them, lost ones named:
#   {1}
# A part that was lost goes on where it was:   sbatch --array=ITS_NUMBER THIS_FILE
#SBATCH --job-name={2}
#SBATCH --array=1-{0}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={3}
#SBATCH --chdir={4}
#SBATCH --output={5}
#SBATCH --requeue
exec {6}
)",
                     job.tasks, MergeCommand(job), ShellWord("kestrel-" + job.name), job.jobs,
                     ShellWord(job.directory.string()), ShellWord(log),
                     ShardCommand(job, fmt::format("\"$SLURM_ARRAY_TASK_ID/{}\"", job.tasks)));
}

std::string ParallelLines(const BatchJob& job, int at_once) {
  // parallel evaluates what stands in {= =} of its command as Perl, so no name stands there: the shell that
  // it starts has them in its environment.
  return fmt::format(
      "cd {} && export KESTREL_PART={} && parallel --jobs {} --joblog {} --resume-failed "
      "'eval \"$KESTREL_PART --shard {{}}/{} --jobs {}\"' ::: $(seq {})\n{}\n",
      ShellWord(job.directory.string()), ShellWord(FlyCommand(job)), at_once,
      ShellWord((job.folder / "logs" / "parallel.log").string()), job.tasks, job.jobs, job.tasks,
      MergeCommand(job));
}

std::string MissingText(const BatchJob& job, const std::vector<std::int64_t>& rows, int parts) {
  const std::string count = fmt::format("  missing: {} row{}", rows.size(), rows.size() == 1 ? "" : "s");
  if (parts == 0) {
    const std::size_t shown = std::min<std::size_t>(rows.size(), 10);
    return fmt::format("{}: {}{}; flown by\n    {}\n", count,
                       fmt::join(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                       shown < rows.size() ? ", ..." : "", FlyCommand(job));
  }
  std::set<std::int64_t> numbers;
  for (const std::int64_t row : rows) numbers.insert(row % parts + 1);
  if (numbers.size() == 1)
    return fmt::format("{} of part {}/{}; flown by\n    {}\n", count, *numbers.begin(), parts,
                       ShardCommand(job, fmt::format("{}/{}", *numbers.begin(), parts)));
  std::string array, words;
  for (const auto& [first, last] : RangesOf(numbers)) {
    const bool one = first == last;
    array += fmt::format("{}{}", array.empty() ? "" : ",",
                         one ? fmt::format("{}", first) : fmt::format("{}-{}", first, last));
    words += one ? fmt::format(" {}", first) : fmt::format(" $(seq {} {})", first, last);
  }
  return fmt::format(
      "{} of {} of {} parts: {}; flown by Slurm's script, or one after the other, by\n"
      "    sbatch --array={} THE_SCRIPT\n    for I in{}; do {}; done\n",
      count, numbers.size(), parts, array, array, words, ShardCommand(job, fmt::format("\"$I/{}\"", parts)));
}

}  // namespace kestrel::campaign
