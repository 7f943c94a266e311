// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kestrel::campaign {

// What flies a campaign's parts on other machines. All of them see the folder, and have the program where it
// is here. None of its texts holds a control character (base/printable.h).
struct BatchJob {
  std::string name;
  std::filesystem::path program;
  std::vector<std::string>
      arguments;  // of `kestrel campaign` and of its merge alike: the file and what it is set to
  std::filesystem::path folder;          // absolute, of the results
  std::filesystem::path directory;       // that the file's name and others are relative to
  std::vector<std::string> environment;  // that it is to have, "NAME=value" each
  int tasks = 1;                         // parts
  int jobs = 1;                          // workers for each
};

// An sbatch script of a job array, a part for each of its tasks, that a lost task may be started with again.
std::string SlurmScript(const BatchJob& job);
// A line for GNU parallel, and the merge after it. at_once: parts that fly at the same time.
std::string ParallelLines(const BatchJob& job, int at_once);
// The commands that fly the whole, or a part, and the one that joins parts.
std::string FlyCommand(const BatchJob& job);
std::string ShardCommand(const BatchJob& job, const std::string& shard);
std::string MergeCommand(const BatchJob& job);
// The rows that a merge misses, and what flies them. parts: that all files are of; 0: there is no such
// number.
std::string MissingText(const BatchJob& job, const std::vector<std::int64_t>& rows, int parts);

}  // namespace kestrel::campaign
