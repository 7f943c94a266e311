// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_campaign.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <set>
#include <thread>

#include "base/random.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/version.h"
#include "campaign/execution/run_campaign.h"

namespace kestrel::bench {
namespace {

namespace fs = std::filesystem;

campaign::CampaignWork ShortHovers(int rows) {
  campaign::CampaignWork work;
  work.scenario = "hover";
  work.set = {"duration_s=0.5", "start.settle_s=0.5"};
  campaign::SampleTable table{{"seed", "wind.mean_m_s"}, {}};
  for (int row = 0; row < rows; ++row)
    table.rows.push_back({fmt::format("{}", row + 1), fmt::format("{:.17g}", 6.0 * row / rows)});
  work.identity = {"bench", "hover", "short hovers", Version(), table};
  return work;
}

campaign::CampaignOptions Options(const fs::path& folder, int jobs) {
  campaign::CampaignOptions options;
  options.folder = folder;
  options.jobs = jobs;
  options.record_failures = 0;
  return options;
}

double CpuOfThisProcess_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::vector<campaign::RunResult> ResultsOf(const fs::path& folder) {
  return campaign::ResultStore::Read(campaign::ResultFile(folder)).Results();
}

// Rows of which the two do not have the same.
int Unlike(const std::vector<campaign::RunResult>& a, const std::vector<campaign::RunResult>& b) {
  if (a.size() != b.size()) return static_cast<int>(std::max(a.size(), b.size()));
  int unlike = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    unlike += a[i].row != b[i].row || !campaign::DifferenceOf(a[i], b[i]).empty();
  return unlike;
}

// Kills the parent at random moments until it was killed so often; campaigns that come to their end before
// that are begun anew.
void Kill(const campaign::CampaignWork& work, const std::vector<campaign::RunResult>& whole, int max_kills,
          const fs::path& folder, std::vector<records::Figure>& table) {
  RandomStream random(1, "kills");
  int kills = 0, lost = 0, unlike = 0, campaigns = 0;
  while (kills < max_kills) {
    const fs::path here = folder / fmt::format("killed-{}", campaigns++);
    std::set<std::int64_t> before;
    for (bool complete = false; !complete;) {
      const pid_t parent = fork();
      if (parent == 0) {
        try {
          campaign::RunCampaign(work, Options(here, 2));
          _exit(0);
        } catch (const std::exception& e) {
          std::fputs(e.what(), stderr);
          _exit(1);
        }
      }
      int status = 0;
      if (kills < max_kills) {
        std::this_thread::sleep_for(std::chrono::duration<double>(random.Uniform(0.2, 4)));
        if (waitpid(parent, &status, WNOHANG) == 0) {
          ++kills;
          kill(parent, SIGKILL);
          waitpid(parent, &status, 0);
        }
      } else {
        waitpid(parent, &status, 0);
      }
      complete = WIFEXITED(status);
      std::set<std::int64_t> now;
      if (fs::exists(campaign::ResultFile(here)) && fs::file_size(campaign::ResultFile(here)) > 0)
        for (const campaign::RunResult& result : ResultsOf(here)) now.insert(result.row);
      lost += !std::includes(now.begin(), now.end(), before.begin(), before.end());
      before = now;
      fmt::print(stderr, "\r\033[Kkilled {} of {} times, {} of {} rows", kills, max_kills, now.size(),
                 whole.size());
    }
    unlike += Unlike(ResultsOf(here), whole);
  }
  fmt::print(stderr, "\r\033[K");
  table.push_back({fmt::format("kill -9 of the parent, {} times: times that a stored row was lost", kills),
                   static_cast<double>(lost), "", 0, false, ""});
  table.push_back({"rows that are missing, twice, or not the same, to the last bit, after the kills",
                   static_cast<double>(unlike), "", 0, false, ""});
}

}  // namespace

void BenchCampaign(int runs, const fs::path& folder, std::vector<records::Figure>& table) {
  fs::remove_all(folder);
  const campaign::CampaignWork work = ShortHovers(runs);
  const double cpu_s = CpuOfThisProcess_s();
  const double one_s = campaign::RunCampaign(work, Options(folder / "one", 1)).progress.wall_s;
  const double parent_ms = 1e3 * (CpuOfThisProcess_s() - cpu_s) / runs;
  const double two_s = campaign::RunCampaign(work, Options(folder / "two", 2)).progress.wall_s;
  const std::vector<campaign::RunResult> one = ResultsOf(folder / "one"), two = ResultsOf(folder / "two");
  std::vector<double> beside_s, flight_s;
  double flown_s = 0;
  for (const campaign::RunResult& r : one) {
    beside_s.push_back(r.execution.orchestration_s);
    flight_s.push_back(r.execution.wall_s - r.execution.orchestration_s);
    flown_s += flight_s.back();
  }
  table.push_back({"beside the flight, of a run in its worker, median", 1e3 * Quantile(beside_s, 0.5), "ms",
                   20, false, ""});
  table.push_back({"beside the flights, all of the wall time of a run, mean",
                   1e3 * (one_s - flown_s) / runs,
                   "ms",
                   {},
                   false,
                   ""});
  table.push_back({"of a run, processor time of the parent", parent_ms, "ms", {}, false, ""});
  table.push_back(
      {"of a flight of 0.5 s, wall time, median", 1e3 * Quantile(flight_s, 0.5), "ms", {}, false, ""});
  table.push_back({"two workers against one", one_s / two_s, "times", 1.85, true, ""});
  table.push_back(
      {"rows not the same by two workers", static_cast<double>(Unlike(one, two)), "", 0, false, ""});
  const auto tenth = static_cast<std::size_t>(runs / 10);
  table.push_back({fmt::format("memory of a worker, peak over {} runs", runs), one.back().execution.peak_mib,
                   "MiB", 400, false, ""});
  table.push_back({fmt::format("of it, since run {}", tenth),
                   one.back().execution.peak_mib - one[tenth].execution.peak_mib,
                   "MiB",
                   {},
                   false,
                   ""});

  const int few = std::min(runs, 12);
  const campaign::CampaignWork short_work = ShortHovers(few);
  campaign::RunCampaign(short_work, Options(folder / "few", 2));
  const std::vector<campaign::RunResult> whole = ResultsOf(folder / "few");
  campaign::CampaignOptions options = Options(folder / "parts", 2);
  std::vector<fs::path> parts;
  for (int number = 1; number <= 3; ++number) {
    options.shard = campaign::Shard{number, 3};
    campaign::RunCampaign(short_work, options);
    parts.push_back(campaign::ResultFile(options.folder, options.shard));
  }
  campaign::Merge(campaign::ResultFile(options.folder), short_work.identity, parts);
  table.push_back({"rows not the same after parts and merge",
                   static_cast<double>(Unlike(ResultsOf(options.folder), whole)), "", 0, false, ""});
  campaign::RunCampaign(short_work, Options(folder / "five", 5));
  table.push_back({"rows not the same by five workers",
                   static_cast<double>(Unlike(ResultsOf(folder / "five"), whole)), "", 0, false, ""});
  Kill(short_work, whole, 50, folder, table);
}

}  // namespace kestrel::bench
