// SPDX-License-Identifier: Apache-2.0
#include "scenarios/landing/descent_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"
#include "scenarios/landing/descent_report.h"

namespace kestrel::scenarios {
namespace {

using control::FuzzySet;
using control::FuzzyVariable;
using records::LogRow;

const DescentReport* ReportOf(const LogRow& row) { return mission::ReportOf<DescentReport>(row.decision); }

// The sets of a variable from low to high, as gnuplot draws them with one colour each.
struct Sets {
  std::vector<std::pair<std::string, FuzzySet>> in_order;
  explicit Sets(const FuzzyVariable& variable) : in_order(variable.sets.begin(), variable.sets.end()) {
    std::stable_sort(in_order.begin(), in_order.end(), [](const auto& a, const auto& b) {
      return a.second.corners.sum() < b.second.corners.sum();
    });
  }
};

const char* SetColour(std::size_t index) {
  static constexpr const char* kColours[] = {"#0072B2", "#009E73", "#E69F00", "#D55E00",
                                             "#882255", "#56B4E9", "#7A5C00"};
  return kColours[index % std::size(kColours)];
}

// A panel with the membership functions of a variable, whose 1 is `scale` of the axis.
std::string Memberships(const FuzzyVariable& variable, double scale, const std::string& axis) {
  std::string data, plots, labels = "unset label\nunset arrow\n";
  const Sets sets(variable);
  for (std::size_t i = 0; i < sets.in_order.size(); ++i) {
    const auto& [name, set] = sets.in_order[i];
    const auto block = fmt::format("$set{}", i);
    data += block + " << END_OF_SET\n";
    for (int k = 0; k < 4; ++k)
      data += fmt::format("{:.6g} {}\n", scale * set.corners[k], k % 3 == 0 ? 0 : 1);
    data += "END_OF_SET\n";
    plots +=
        fmt::format("{}{} using 1:2 with lines lw 2.4 lc rgb '{}'", i ? ", " : "plot ", block, SetColour(i));
    const double middle = std::clamp((set.corners[1] + set.corners[2]) / 2, variable.low, variable.high);
    labels += fmt::format("set label {} at first {:.6g}, first 1.08 center tc rgb '{}' noenhanced\n",
                          records::GnuplotQuoted(name), scale * middle, SetColour(i));
  }
  return data + labels +
         fmt::format("set xrange [{:.6g}:{:.6g}]\nset yrange [0:1.2]\nset ytics 0,0.5,1\nset xlabel {}\n{}\n",
                     scale * variable.low, scale * variable.high, records::GnuplotQuoted(axis), plots);
}

constexpr int kCells = 60;  // of the surface, along each input

std::string SurfaceData(const FuzzyDescentLaw& law) {
  const FuzzyVariable &error = law.height.controller.inputs.at("error"),
                      &rate = law.height.controller.inputs.at("rate");
  std::string data = "$surface << END_OF_SURFACE\n";
  for (int j = 0; j <= kCells; ++j) {
    const double sink_m_s = law.height.rate_scale_m_s * (rate.low + (rate.high - rate.low) * j / kCells);
    for (int i = 0; i <= kCells; ++i) {
      const double height_m = law.height.error_scale_m * (error.low + (error.high - error.low) * i / kCells);
      const auto descent = control::FuzzyDescent(law.height, law.inference, height_m, sink_m_s);
      data += fmt::format("{:.6g} {:.6g} {:.6g}\n", height_m, sink_m_s, descent.value_or(records::kNone));
    }
    data += '\n';
  }
  return data + "END_OF_SURFACE\n";
}

std::string FlownData(const std::vector<LogRow>& rows) {
  std::string data = "$flown << END_OF_FLOWN\n";
  for (const LogRow& row : rows)
    if (const DescentReport* report = ReportOf(row))
      data += fmt::format("{:.6g} {:.6g} {:.6g}\n", report->height_m, report->sink_m_s, report->descent_m_s);
    else
      data += '\n';  // a line ends
  return data + "END_OF_FLOWN\n";
}

}  // namespace

bool DescendsByRules(const std::vector<LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const LogRow& row) { return ReportOf(row) != nullptr; });
}

std::string DescentPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                        const mission::FigureText& figure) {
  const auto first = std::find_if(rows.begin(), rows.end(), ReportOf);
  const FuzzyDescentLaw& law = *ReportOf(*first)->law;
  const control::FuzzyHeight& height = law.height;
  const FuzzyVariable &error = height.controller.inputs.at("error"),
                      &rate = height.controller.inputs.at("rate");
  const auto margins = [](double left, double right, double bottom, double top) {
    return fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen "
        "{}\n",
        left, right, bottom, top);
  };
  std::string text = SurfaceData(law) + FlownData(rows) + records::BeginFigure(file, 1600, 1000) +
                     fmt::format("set multiplot title {} noenhanced font ',14'\nunset key\n",
                                 records::GnuplotQuoted("Descent by fuzzy rules: " + figure.title));
  text += "set ylabel 'membership' offset 1,0\n";
  text += margins(0.06, 0.44, 0.72, 0.91) +
          Memberships(error, height.error_scale_m, "error: height above the pad (m)");
  text += margins(0.06, 0.44, 0.40, 0.59) + Memberships(rate, height.rate_scale_m_s, "rate: sink rate (m/s)");
  text += margins(0.06, 0.44, 0.08, 0.27) +
          Memberships(height.controller.outputs.at("descent"), height.descent_scale_m_s,
                      "descent: velocity downwards that is commanded (m/s)");
  text += margins(0.53, 0.89, 0.08, 0.91) +
          fmt::format(
              "unset label\nset xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\nset ytics auto\n"
              "set xlabel 'height above the pad (m)'\nset ylabel 'sink rate (m/s)' offset 1,0\n"
              "set cblabel 'velocity downwards that is commanded (m/s)'\n"
              "set palette defined (0 '#f7fbff', 0.5 '#6baed6', 1 '#08306b')\n"
              "set key at graph 0.98, graph 1.045 right top noautotitle samplen 2\n"
              "plot $surface using 1:2:3 with image, "
              "$flown using 1:2 with lines lw 1.8 lc rgb '#E69F00' title 'this flight'\n",
              height.error_scale_m * error.low, height.error_scale_m * error.high,
              height.rate_scale_m_s * rate.low, height.rate_scale_m_s * rate.high);
  return text + records::EndFigure();
}

}  // namespace kestrel::scenarios
