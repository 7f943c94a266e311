// SPDX-License-Identifier: Apache-2.0
#include "scenarios/stabilise/stabilise_plot.h"

#include <fmt/format.h>

#include <algorithm>

#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"
#include "scenarios/stabilise/corner_motion.h"
#include "scenarios/stabilise/stabilise_report.h"

namespace kestrel::scenarios {
namespace {

constexpr const char* kInStyle = "lines lw 1 lc rgb '#999999'";
constexpr const char* kOutStyle = "lines lw 1.8 lc rgb '#882255'";

// The places after each step, less the mean of those that are up to a second away.
std::vector<double> WithoutSlowMotion(const std::vector<double>& steps, double rate_hz) {
  const auto n = static_cast<std::ptrdiff_t>(steps.size());
  std::vector<double> sums = {0}, of_places = {0};
  for (const double step : steps) sums.push_back(sums.back() + step);
  for (std::ptrdiff_t i = 0; i < n; ++i)
    of_places.push_back(of_places.back() + sums[static_cast<std::size_t>(i) + 1]);
  std::vector<double> fast;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto reach = std::min({static_cast<std::ptrdiff_t>(rate_hz), i, n - 1 - i});
    const double mean = (of_places[static_cast<std::size_t>(i + reach) + 1] -
                         of_places[static_cast<std::size_t>(i - reach)]) /
                        static_cast<double>(2 * reach + 1);
    fast.push_back(sums[static_cast<std::size_t>(i) + 1] - mean);
  }
  return fast;
}

}  // namespace

bool ShowsStabilised(const std::vector<mission::LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const mission::LogRow& row) {
    const auto* report = mission::ReportOf<StabiliseReport>(row.decision);
    return report && report->shown;
  });
}

std::string CornerMotionPlot(const std::filesystem::path& file, const std::vector<mission::LogRow>& rows,
                             const mission::FigureText& figure) {
  const std::vector<CornerFlow> flows = CornerFlows(rows);
  const double span_s = flows.size() < 2 ? 1 : flows.back().t_s - flows.front().t_s;
  const double rate_hz = static_cast<double>(std::max<std::size_t>(flows.size(), 2) - 1) / span_s;
  // Of the first corner: u and v, as they came in and stabilised.
  std::vector<double> steps[4];
  for (const CornerFlow& flow : flows)
    for (std::size_t i = 0; i < 4; ++i)
      steps[i].push_back((i % 2 == 0 ? flow.in : flow.out)[0][static_cast<int>(i / 2)]);
  std::string text = "$motion << END_OF_MOTION\n";
  std::vector<double> fast[4], amplitudes[4];
  for (std::size_t i = 0; i < 4; ++i)
    fast[i] = WithoutSlowMotion(steps[i], rate_hz), amplitudes[i] = PathAmplitudes(steps[i]);
  for (std::size_t k = 0; k < flows.size(); ++k)
    text += fmt::format("{:.4f} {:.5g} {:.5g} {:.5g} {:.5g}\n", flows[k].t_s, fast[0][k], fast[1][k],
                        fast[2][k], fast[3][k]);
  text += "END_OF_MOTION\n$spectrum << END_OF_SPECTRUM\n";
  for (std::size_t k = 1; k < amplitudes[0].size(); ++k) {
    text += fmt::format("{:.5g}", rate_hz * static_cast<double>(k) / static_cast<double>(flows.size()));
    for (const std::vector<double>& each : amplitudes) text += fmt::format(" {:.5g}", each[k]);
    text += '\n';
  }
  text += "END_OF_SPECTRUM\n" + records::BeginFigure(file, 1400, 1000) +
          records::BeginPanels("layout 3,1 margins 0.08,0.97,0.07,0.91 spacing 0,0.06",
                               "What is seen at a corner of the view: " + figure.title) +
          "set xrange " + records::TimeRange(rows) + '\n';
  for (int axis = 0; axis < 2; ++axis)
    text +=
        records::PhaseLines(rows, false) + records::AxisName(axis == 0 ? "right (px)" : "down (px)") +
        (axis == 0 ? records::kKey : "unset key\nset format x '%g'\nset xlabel 'time (s)' offset 0,0.6\n") +
        fmt::format(
            "plot $motion using 1:{} with {} title 'as it came in', '' using 1:{} with {} title "
            "'stabilised'\n",
            2 + 2 * axis, kInStyle, 3 + 2 * axis, kOutStyle);
  return text +
         fmt::format(
             "unset arrow\nunset label\n{}set xlabel 'frequency (Hz)'\nset xrange [{}:*]\nset logscale xy\n"
             "plot $spectrum using 1:($2**2+$4**2)**0.5 with {}, '' using 1:($3**2+$5**2)**0.5 with {}\n",
             records::AxisName("amplitude (px)"), 0.1, kInStyle, kOutStyle) +
         records::EndFigure();
}

}  // namespace kestrel::scenarios
