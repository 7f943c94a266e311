// SPDX-License-Identifier: Apache-2.0
#include "scenarios/fly_all.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <thread>

namespace kestrel {

std::vector<FlownScenario> FlyAll(const std::string& scenario, const std::vector<std::string>& overrides,
                                  SeedRange seeds, int jobs, const std::string& title) {
  std::vector<FlownScenario> flights;
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    auto all = overrides;
    all.push_back(fmt::format("seed={}", seed));
    flights.push_back({LoadScenario(scenario, all), {}, {}});
  }
  std::atomic<std::size_t> next = 0, done = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  std::vector<std::thread> workers;
  for (int w = 0; w < jobs; ++w) {
    workers.emplace_back([&] {
      for (std::size_t i; (i = next++) < flights.size();) {
        try {
          FlightResult result = RunFlight(flights[i].loaded, {});
          if (!result.summary.complete) {
            throw std::runtime_error(fmt::format("{}, seed {}: {}", scenario, flights[i].loaded.scenario.seed,
                                                 result.summary.error));
          }
          flights[i].summary = std::move(result.summary);
          flights[i].rows = std::move(result.rows);
        } catch (...) {
          const std::lock_guard lock(mutex);
          if (!failure) failure = std::current_exception();
        }
        ++done;
        const std::lock_guard lock(mutex);
        if (isatty(STDERR_FILENO))
          fmt::print(stderr, "\r\033[K{}: {} of {} flights", title, done.load(), flights.size());
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
  if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[K");
  if (failure) std::rethrow_exception(failure);
  return flights;
}

std::vector<double> Values(const std::vector<FlownScenario>& flights, const std::string& metric) {
  std::vector<double> values;
  for (const FlownScenario& flight : flights) {
    const auto found = flight.summary.metrics.find(metric);
    values.push_back(found != flight.summary.metrics.end() ? found->second
                                                           : std::numeric_limits<double>::infinity());
  }
  return values;
}

double Quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const std::size_t low = static_cast<std::size_t>(at);
  if (low + 1 >= values.size()) return values.back();
  return values[low] + (at - static_cast<double>(low)) * (values[low + 1] - values[low]);
}
double Largest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }
double Rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace kestrel
