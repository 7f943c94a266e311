// SPDX-License-Identifier: Apache-2.0
#include "bench/limits/bench_limits.h"

#include <fmt/format.h>

#include <array>
#include <string>

#include "base/process/status_line.h"
#include "bench/limits/flight_stages.h"
#include "bench/limits/frame_bounds.h"
#include "bench/limits/frame_stages.h"
#include "bench/limits/machine_rates.h"
#include "bench/named_camera.h"

namespace kestrel::bench {
namespace {

struct View {
  const char *name, *scenario, *camera;
  double height_m;
};
constexpr std::array kViews = {View{"pinhole, airfield", "survey_airfield", "thesis_6mm", 5},
                               View{"mirror, airfield", "survey_airfield", "hyperbolic_mirror", 5},
                               View{"fisheye, airfield", "survey_airfield", "fisheye", 5},
                               View{"mirror, landscape", "attitude_2", "hyperbolic_mirror", 20}};
constexpr int kFrames = 8;

struct Flight {
  const char* scenario;
  double duration_s;
};
constexpr std::array kFlights = {Flight{"landing", 20}, Flight{"hover", 20},     Flight{"follow", 20},
                                 Flight{"avoid", 20},   Flight{"attitude_2", 8}, Flight{"gyro_failure", 8}};
constexpr std::array kStages = {"physics", "render", "sensor", "vision", "control", "record"};

class FigureList {
 public:
  explicit FigureList(std::vector<records::Figure>& figures) : figures_(figures) {}
  void Add(const std::string& name, double value, const char* unit, bool at_least = false) {
    figures_.push_back({name, value, unit, {}, at_least, ""});
  }

 private:
  std::vector<records::Figure>& figures_;
};

void PrintMachine(const MachineRates& rates, FigureList list) {
  fmt::print(
      "One core by {}: {:.1f} G multiplications and additions of floats a second in multiply-adds, {:.2f} "
      "divisions a ns.\n\n",
      rates.instruction_set, rates.multiply_adds_gflop_s, rates.divisions_per_ns);
  list.Add("multiply-adds, float", rates.multiply_adds_gflop_s, "Gflop/s", true);
  list.Add("divisions, float", rates.divisions_per_ns, "1/ns", true);
  fmt::print(
      "| read from a buffer of | in order, GB/s | at random, reads/us |\n|{:-<23}|{:->15}:|{:->20}:|\n", "",
      "", "");
  for (const MemoryRate& m : rates.memory) {
    fmt::print("| {:<21} | {:>14.1f} | {:>19.0f} |\n", m.level, m.read_gb_s, m.random_reads_per_us);
    list.Add("read of " + m.level + ", in order", m.read_gb_s, "GB/s", true);
    list.Add("read of " + m.level + ", at random", m.random_reads_per_us, "reads/us", true);
  }
}

void PrintFrames(const MachineRates& rates, StatusLine& line, FigureList list) {
  struct Row {
    std::string name;
    StagedFrame frame;
    FrameBounds bounds;
  };
  std::vector<Row> rows;
  for (const View& view : kViews) {
    line.Show(view.name);
    StagedRenderer renderer(view.scenario, NamedCamera(view.camera));
    const StagedFrame frame = MeanFrame(renderer, view.height_m, kFrames);
    rows.push_back({view.name, frame, BoundsOf(frame.content, rates)});
  }
  line.Clear();
  fmt::print(
      "\n| a frame: what is in it | pixels | textured | at edges |\n|{:-<24}|{:->7}:|{:->9}:|{:->9}:|\n", "",
      "", "", "");
  for (const Row& row : rows)
    fmt::print("| {:<22} | {:>6.0f} | {:>8.0f} | {:>8.0f} |\n", row.name, row.frame.content.pixels,
               row.frame.content.textured, row.frame.content.at_edges);
  fmt::print(
      "\n| at least, ms           | memory | random reads | arithmetic | the most | takes | times |\n"
      "|{:-<24}|{:->7}:|{:->13}:|{:->11}:|{:->9}:|{:->6}:|{:->6}:|\n",
      "", "", "", "", "", "", "");
  for (const Row& row : rows) {
    const double takes_ms = row.frame.stages.Sum();
    fmt::print("| {:<22} | {:>6.2f} | {:>12.2f} | {:>10.2f} | {:>8.2f} | {:>5.2f} | {:>5.1f} |\n", row.name,
               row.bounds.memory_ms, row.bounds.random_ms, row.bounds.arithmetic_ms, row.bounds.Least(),
               takes_ms, takes_ms / row.bounds.Least());
    list.Add(row.name + ", at least", row.bounds.Least(), "ms");
    list.Add(row.name + ", takes", takes_ms, "ms");
  }
  fmt::print(
      "\n| takes, ms              | set-up | lists | a ray a pixel | edges | an edge, ns |\n"
      "|{:-<24}|{:->7}:|{:->6}:|{:->14}:|{:->6}:|{:->12}:|\n",
      "", "", "", "", "", "");
  for (const Row& row : rows) {
    const FrameStages& s = row.frame.stages;
    const double edges = row.frame.content.at_edges;
    fmt::print("| {:<22} | {:>6.2f} | {:>5.2f} | {:>13.2f} | {:>5.2f} | {:>11} |\n", row.name, s.set_up_ms,
               s.list_ms, s.rays_ms, s.edges_ms,
               edges > 0 ? fmt::format("{:.0f}", 1e6 * s.edges_ms / edges) : "");
  }
}

void PrintFlights(StatusLine& line, FigureList list) {
  std::string head = "\n| ms a frame, one core   |", rule = fmt::format("|{:-<24}|", "");
  for (const char* stage : kStages) {
    head += fmt::format(" {:>7} |", stage);
    rule += fmt::format("{:->8}:|", "");
  }
  fmt::print(
      "{} of frame | x real time, one core | two cores at most | two cores "
      "|\n{}{:->9}:|{:->22}:|{:->18}:|{:->10}:|\n",
      head, rule, "", "", "", "");
  for (const Flight& flight : kFlights) {
    line.Show(flight.scenario);
    const FlightStages flown = StagesOfFlight(flight.scenario, flight.duration_s);
    line.Clear();
    std::string row = fmt::format("| {:<22} |", flight.scenario);
    for (const char* stage : kStages) {
      const auto at = flown.stages_ms.find(stage);
      row += fmt::format(" {:>7.2f} |", at == flown.stages_ms.end() ? 0.0 : at->second);
    }
    fmt::print("{} {:>8.1f} | {:>21.1f} | {:>17.1f} | {:>9.1f} |\n", row, 1e3 * flown.frame_s, flown.by_one,
               flown.AtMostByTwo(), flown.by_two);
    list.Add(std::string(flight.scenario) + ", one core", flown.by_one, "x real time", true);
    list.Add(std::string(flight.scenario) + ", two cores", flown.by_two, "x real time", true);
  }
}

}  // namespace

void BenchLimits(std::vector<records::Figure>& figures) {
  const FigureList list(figures);
  StatusLine line("limits");
  line.Show("this machine");
  const MachineRates rates = MeasureMachineRates();
  line.Clear();
  PrintMachine(rates, list);
  PrintFrames(rates, line, list);
  PrintFlights(line, list);
}

}  // namespace kestrel::bench
