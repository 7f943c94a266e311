// SPDX-License-Identifier: Apache-2.0
#include "bench/throughput/bench_throughput.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <barrier>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "base/process/own_program.h"
#include "base/process/status_line.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/version.h"
#include "bench/throughput/scaling.h"
#include "bench/timings/timed_program.h"
#include "campaign/execution/run_campaign.h"

namespace kestrel::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kFlightsOfAWorker = 6;
constexpr double kSecondsOfFrames = 3;
constexpr const char* kFrames = "pinhole, airfield";  // as bench timings has it

// Landings from low above the pad, in winds from none to 6 m/s.
campaign::CampaignWork ShortLandings(int rows, const std::vector<std::string>& more) {
  campaign::CampaignWork work;
  work.scenario = "landing";
  work.set = {"start.height_m=3"};
  work.set.insert(work.set.end(), more.begin(), more.end());
  campaign::SampleTable table{{"seed", "wind.mean_m_s"}, {}};
  for (int row = 0; row < rows; ++row)
    table.rows.push_back({fmt::format("{}", row % kFlightsOfAWorker + 1),
                          fmt::format("{:.17g}", 6.0 * (row % kFlightsOfAWorker) / kFlightsOfAWorker)});
  work.identity = {"bench", "landing", "short landings", Version(), table};
  return work;
}

struct Flown {
  double an_hour = 0;
  double flight_s = 0;  // median
  double peak_mib = 0;  // of the worker that needed most
};

// Each worker has the same flights to fly, however many they are.
Flown Fly(int workers, const fs::path& folder, StatusLine& line, const std::string& what,
          const std::vector<std::string>& more = {}) {
  const campaign::CampaignWork work = ShortLandings(workers * kFlightsOfAWorker, more);
  campaign::CampaignOptions options;
  options.folder = folder;
  options.jobs = workers;
  options.record_failures = 0;
  options.show = [&](const campaign::Progress& p) {
    line.Show(fmt::format("{}, {} at a time: {} of {} flights", what, workers, p.done, p.rows));
  };
  const campaign::Progress progress = campaign::RunCampaign(work, options).progress;
  Flown flown{3600 * progress.Rate(), 0, 0};
  std::vector<double> flights_s;
  for (const campaign::RunResult& r : campaign::ResultStore::Read(campaign::ResultFile(folder)).Results()) {
    flights_s.push_back(r.execution.wall_s);
    flown.peak_mib = std::max(flown.peak_mib, r.execution.peak_mib);
    if (r.status != campaign::RunStatus::kPassed && r.status != campaign::RunStatus::kFailed)
      throw std::runtime_error(fmt::format("a landing of the throughput ended by itself: {}", r.outcome));
  }
  flown.flight_s = Quantile(flights_s, 0.5);
  return flown;
}

// A block of frames, made ready on the thread that draws them.
using Draw = std::function<double()>;  // returns how many

// Frames a second of so many threads here, each of which has its own to draw by.
double FrameRate(int at_once, const std::function<Draw()>& make) {
  std::barrier all_ready(at_once);
  std::atomic<double> frames = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
  std::vector<std::thread> threads;
  for (int k = 0; k < at_once; ++k)
    threads.emplace_back([&] {
      Draw draw;
      const auto unless_failed = [&](auto&& act) {
        try {
          act();
        } catch (...) {
          if (!failed.exchange(true)) failure = std::current_exception();
        }
      };
      unless_failed([&] { draw = make(), draw(); });
      all_ready.arrive_and_wait();
      if (failed) return all_ready.arrive_and_drop();
      const auto start = std::chrono::steady_clock::now();
      double drawn = 0;
      unless_failed([&] {
        while (SecondsSince(start) < kSecondsOfFrames) drawn += draw();
      });
      // Each by its own time, which ends with its last block.
      frames += drawn / SecondsSince(start);
      all_ready.arrive_and_wait();  // nobody goes while others draw
    });
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  return frames;
}

double ByProcesses(int at_once, StatusLine& line) {
  line.Show(fmt::format("frames by {} processes", at_once));
  return FrameRate(at_once, [] {
    return [program = std::make_shared<TimedProgram>(OwnProgram())] { return program->Time(kFrames).pieces; };
  });
}

double ByThreads(int at_once, StatusLine& line) {
  line.Show(fmt::format("frames by {} threads", at_once));
  return FrameRate(at_once, [] { return [block = PrepareWork(kFrames)] { return block().pieces; }; });
}

// The table's, for one kind of work.
struct Column {
  std::string name, unit;
  std::vector<WorkersRate> rates;
};

void Print(const std::vector<Column>& columns, const std::vector<Flown>& flown) {
  std::string head = "| workers |", rule = "|--------:|";
  for (const Column& column : columns) {
    head += fmt::format(" {:>20} | {:>5} | {:>10} |", column.name, "times", "efficiency");
    rule += fmt::format("{:->21}:|{:->6}:|{:->11}:|", "", "", "");
  }
  fmt::print("{} {:>10} |\n{}{:->11}:|\n", head, "peak, MiB", rule, "");
  for (std::size_t i = 0; i < flown.size(); ++i) {
    std::string row = fmt::format("| {:>7} |", columns.front().rates[i].workers);
    for (const Column& column : columns) {
      const Scaling scaling = ScalingOf(column.rates)[i];
      row += fmt::format(" {:>20.0f} | {:>5.2f} | {:>10.2f} |", column.rates[i].rate, scaling.times_one,
                         scaling.efficiency);
    }
    fmt::print("{} {:>10.0f} |\n", row, flown[i].peak_mib);
  }
}

}  // namespace

void BenchThroughput(const fs::path& folder, std::vector<records::Figure>& table) {
  fs::remove_all(folder);
  StatusLine line("throughput");
  const std::vector<int> counts = WorkerCounts(campaign::Cores());
  Column landings{"landings an hour", "flights/h", {}};
  Column by_processes{"frames/s, processes", "frames/s", {}}, by_threads{"frames/s, threads", "frames/s", {}};
  std::vector<Flown> flown;
  for (const int n : counts) {
    landings.rates.push_back({n, 0}), by_processes.rates.push_back({n, 0}),
        by_threads.rates.push_back({n, 0});
    flown.emplace_back();
  }
  // Up and down again, and the better of both: what else the machine does only slows it.
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < counts.size(); ++i) order.push_back(i);
  for (std::size_t i = counts.size(); i-- > 0;) order.push_back(i);
  double flight_s = 0, start_s = 0;
  for (std::size_t step = 0; step < order.size(); ++step) {
    const std::size_t i = order[step];
    const int n = counts[i];
    const auto better = [](double& best, double now) { best = std::max(best, now); };
    const Flown now = Fly(n, folder / fmt::format("{}", step), line, "landings");
    better(landings.rates[i].rate, now.an_hour);
    better(flown[i].peak_mib, now.peak_mib);
    if (n == 1) {
      const double start_now_s =
          Fly(1, folder / fmt::format("start-{}", step), line, "starts", {"duration_s=0.1", "criteria={}"})
              .flight_s;
      flight_s = flight_s > 0 ? std::min(flight_s, now.flight_s) : now.flight_s;
      start_s = start_s > 0 ? std::min(start_s, start_now_s) : start_now_s;
    }
    better(by_processes.rates[i].rate, ByProcesses(n, line));
    better(by_threads.rates[i].rate, ByThreads(n, line));
  }
  line.Clear();
  const std::vector<Column> columns = {landings, by_processes, by_threads};
  Print(columns, flown);
  fmt::print(
      "{} cores. Of a landing of {:.2f} s by one worker, {:.0f} ms ({:.0f} %) are its start: what it takes "
      "to fly "
      "its first 0.1 s.\n",
      campaign::Cores(), flight_s, 1e3 * start_s, 100 * start_s / flight_s);
  for (const Column& column : columns)
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const std::string name = fmt::format("{} by {}", column.name, counts[i]);
      const Scaling scaling = ScalingOf(column.rates)[i];
      table.push_back({name, column.rates[i].rate, column.unit, {}, true, ""});
      table.push_back({name + ", as one", scaling.times_one, "times", {}, true, ""});
      table.push_back({name + ", efficiency", scaling.efficiency, "share", {}, true, ""});
    }
  for (std::size_t i = 0; i < counts.size(); ++i)
    table.push_back(
        {fmt::format("memory of a worker, peak, by {}", counts[i]), flown[i].peak_mib, "MiB", {}, false, ""});
  table.push_back({"start of a landing by one worker", start_s / flight_s, "share", {}, false, ""});
}

}  // namespace kestrel::bench
