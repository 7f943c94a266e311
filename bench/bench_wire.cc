// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_wire.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/process/in_parallel.h"
#include "base/statistics.h"
#include "flight/served/link_faults.h"
#include "flight/served/wire_flight.h"

namespace kestrel::bench {
namespace {

constexpr double kWithin_m = 0.2;

void AddOf(flight::Wire wire, const std::vector<flight::WireFlown>& flights,
           std::vector<records::Figure>& table) {
  const std::string name = flight::NameOf(wire);
  const double count = static_cast<double>(flights.size());
  double landed = 0, stretched_s = 0, flown = 0;
  std::vector<double> error_m, latency_ms, late_ms;
  for (const flight::WireFlown& f : flights) {
    if (f.Landed() && f.status == 0) ++landed;
    error_m.push_back(f.TouchdownError_m());
    stretched_s += f.Stretched_s();
    flown += static_cast<double>(f.images.size());
    for (const double s : flight::AddedLatency_s(f, wire)) latency_ms.push_back(1e3 * s);
    for (const flight::PublishedImage& image : f.published)
      late_ms.push_back(1e3 * (image.t_s - image.due_s));
  }
  const std::string of = fmt::format("of {:g}", count);
  table.push_back({name + ", landed", landed, of, count, true, ""});
  table.push_back({name + ", touch-down error, worst", Largest(error_m), "m", kWithin_m, false, ""});
  table.push_back({name + ", touch-down error, mean", Mean(error_m), "m", {}, false, ""});
  table.push_back({name + ", image given to setpoint received, mean", Mean(latency_ms), "ms", 25, false, ""});
  table.push_back({name + ", the same, 99th percentile", Quantile(latency_ms, 0.99), "ms", 50, false, ""});
  table.push_back({name + ", images whose setpoint was recognised",
                   static_cast<double>(latency_ms.size()),
                   fmt::format("of {:g}", flown),
                   {},
                   false,
                   ""});
  table.push_back({name + ", images given later than due, mean", Mean(late_ms), "ms", {}, false, ""});
  table.push_back({name + ", the same, 99th percentile", Quantile(late_ms, 0.99), "ms", {}, false, ""});
  table.push_back({name + ", time given up by the machine", stretched_s, "s", {}, false, ""});
}

}  // namespace

void BenchWire(flight::SeedRange seeds, int jobs, const std::filesystem::path& folder,
               std::vector<records::Figure>& table) {
  flight::HardwareProgram();
  const std::size_t count = seeds.last - seeds.first + 1;
  for (const flight::Wire wire : flight::kWires) {
    std::vector<flight::WireFlown> flights(count);
    InParallel(
        count, jobs, fmt::format("landing by {}", flight::NameOf(wire)), "flights", [&](std::size_t i) {
          flight::WireFlightOptions o;
          o.wire = wire;
          o.seed = seeds.first + i;
          o.folder = folder / fmt::format("{}-{}", flight::NameOf(wire), o.seed);
          flights[i] = flight::FlyOverWire(o);
          const flight::WireFlown& f = flights[i];
          if (!f.Landed() || !(f.TouchdownError_m() <= kWithin_m) || f.status != 0)
            fmt::print(stderr, "{}, seed {}: {}, touch-down error {:.3f} m, the program's status {}; {}\n",
                       flight::NameOf(wire), o.seed, f.served.outcome, f.TouchdownError_m(),
                       f.status.value_or(-1), o.folder.string());
        });
    AddOf(wire, flights, table);
  }
}

void BenchLinkFaults(flight::SeedRange seeds, int jobs, const std::filesystem::path& folder,
                     std::vector<records::Figure>& table) {
  flight::HardwareProgram();
  const std::size_t count = seeds.last - seeds.first + 1;
  for (const flight::FaultRow& row : flight::kFaults) {
    std::vector<flight::FaultJudgement> judged(count);
    std::vector<double> stretched_s(count);
    InParallel(count, jobs, std::string(row.name), "flights", [&](std::size_t i) {
      const std::uint64_t seed = seeds.first + i;
      const flight::Wire wire = flight::kWires[seed % (row.by_datagrams ? 2 : std::size(flight::kWires))];
      std::string name(row.name);
      std::replace_if(
          name.begin(), name.end(), [](char c) { return c == ' ' || c == '%'; }, '_');
      const flight::WireFlightOptions o = flight::FlightWith(
          row, wire, seed, folder / fmt::format("{}-{}-{}", name, flight::NameOf(wire), seed));
      const flight::WireFlown flown = flight::FlyOverWire(o);
      judged[i] = flight::JudgeFault(row, flown, {}, kWithin_m);
      stretched_s[i] = flown.Stretched_s();
      for (const std::string& wrong : judged[i].wrong)
        fmt::print(stderr, "{}, {}, seed {}: {} ({:.1f} s given up by the machine); {}\n", row.name,
                   flight::NameOf(wire), seed, wrong, stretched_s[i], o.folder.string());
    });
    double as_written = 0;
    std::vector<double> reaction_s;
    for (const flight::FaultJudgement& j : judged) {
      if (j.wrong.empty()) ++as_written;
      if (j.reaction_s) reaction_s.push_back(*j.reaction_s);
    }
    const std::string name(row.name);
    const std::string what =
        row.hazard == control::Hazard::kNone
            ? "it landed"
            : fmt::format("{}, then {}", control::NameOf(row.first), control::NameOf(row.later));
    table.push_back({fmt::format("{}: {}", name, what), as_written, fmt::format("of {}", count),
                     static_cast<double>(count), true, ""});
    if (row.limit)
      table.push_back({name + ", slowest reaction", Largest(reaction_s), "s",
                       control::SafetyLimits{}.*row.limit + flight::kReactionMargin_s, false, ""});
    table.push_back(
        {name + ", time given up by the machine, worst", Largest(stretched_s), "s", {}, false, ""});
  }
}

}  // namespace kestrel::bench
