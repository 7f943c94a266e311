// SPDX-License-Identifier: Apache-2.0
#include "records/plot/plot_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/file/files.h"
#include "records/plot/gnuplot.h"

namespace kestrel::records {

const char* TargetColour(std::size_t index) {
  static constexpr const char* kColours[] = {"#882255", "#7A5C00", "#56B4E9", "#999933"};
  return kColours[index % std::size(kColours)];
}

void Span::Add(double value) {
  if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
}

std::string Span::Range(double least) const {
  if (!(low <= high)) return fmt::format("[{}:{}]", -least / 2, least / 2);
  const double grow = std::max(0.06 * size(), (least - size()) / 2);
  return fmt::format("[{:.6g}:{:.6g}]", low - grow, high + grow);
}

double TickStep(const Span& span, double least) {
  const double wanted = std::max(span.size(), least) / 5;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  for (const double each : {1, 2, 5}) {
    if (each * power >= wanted) return each * power;
  }
  return 10 * power;
}

std::string TimeRange(const std::vector<LogRow>& rows) {
  const double first_s = rows.front().exposure.t_s;
  return fmt::format("[{:.4f}:{:.4f}]", first_s, std::max(rows.back().now.t_s, first_s + 0.1));
}

std::string PhaseLines(const std::vector<LogRow>& rows, bool named) {
  const double first_s = rows.front().exposure.t_s, all_s = rows.back().now.t_s - first_s;
  std::string text = "unset arrow\nunset label\n";
  double free_s = first_s;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i > 0 && rows[i].decision.phase == rows[i - 1].decision.phase) continue;
    const double t_s = rows[i].exposure.t_s;
    if (i > 0) {
      text += fmt::format(
          "set arrow from first {0:.4f}, graph 0 to first {0:.4f}, graph 1 nohead dt 3 lc rgb '#999999'\n",
          t_s);
    }
    const std::string name(rows[i].decision.phase);
    const double end_s =
        t_s + 0.008 * all_s * static_cast<double>(name.size() + 1);  // so wide are its letters
    if (!named || t_s < free_s || end_s > first_s + 1.02 * all_s) continue;
    free_s = end_s;
    text +=
        fmt::format("set label {} at first {:.4f}, graph 1.05 left tc rgb '#666666' font ',10' noenhanced\n",
                    GnuplotQuoted(name), t_s);
  }
  return text;
}

std::string LimitLines(const mission::FigureText& figure, const std::vector<std::string>& metrics, Span& span,
                       bool is_signed) {
  constexpr double kFar = 2;  // times as far as the data reach from zero
  std::string text;
  double words_at = 0.94, beside = 0.995;
  for (const mission::MetricLimit& each : figure.limits) {
    if (std::find(metrics.begin(), metrics.end(), each.metric) == metrics.end()) continue;
    const std::string words =
        fmt::format("{} at {} {:g}", each.metric, each.at_least ? "least" : "most", each.limit);
    const bool any = span.low <= span.high;
    const double reach = any ? std::max(std::abs(span.low), std::abs(span.high)) : 0;
    const auto label = [&](const std::string& said, const std::string& at) {
      text += fmt::format("set label {} at {} right tc rgb '#D55E00' font ',9' noenhanced front\n",
                          GnuplotQuoted(said), at);
    };
    if (any && std::abs(each.limit) > kFar * reach) {
      label(words + ", beyond this panel", fmt::format("graph 0.995, graph {:.2f}", words_at));
      words_at -= 0.1;
      continue;
    }
    for (const double limit : {each.limit, -each.limit}) {
      span.Add(limit);
      text += fmt::format(
          "set arrow from graph 0, first {0:.6g} to graph 1, first {0:.6g} nohead dt (6,4) lw 1.4 lc rgb "
          "'#D55E00' front\n",
          limit);
      if (!is_signed) break;
    }
    label(words, fmt::format("graph {:.3f}, first {:.6g} offset 0,0.6", beside, each.limit));
    beside -= 0.3;  // the next line may be near
  }
  return text;
}

std::string Shades(const std::vector<LogRow>& rows,
                   const std::function<std::string_view(const LogRow&)>& colour) {
  std::string text = "unset object\n";
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i;
    while (end < rows.size() && colour(rows[end]) == colour(rows[i])) ++end;
    text += fmt::format(
        "set object rectangle from first {:.4f}, graph 0 to first {:.4f}, graph 1 behind fc rgb '{}' "
        "fs solid noborder\n",
        rows[i].now.t_s, rows[std::min(end, rows.size() - 1)].now.t_s, colour(rows[i]));
    i = end;
  }
  return text;
}

std::string BeginFigure(const std::filesystem::path& file, int width_px, int height_px) {
  return fmt::format(
      "reset\nset terminal pngcairo size {},{} font 'DejaVu Sans,12' background rgb 'white'\n"
      "{}set encoding utf8\n"
      "set border 3 lc rgb '#444444'\nset tics nomirror out scale 0.6\n"
      "set grid lc rgb '#dddddd' lt 1 lw 1\n",
      width_px, height_px, GnuplotOutput(file));
}

std::string EndFigure() { return "unset multiplot\nunset output\n"; }

std::string BeginPanels(const std::string& layout, const std::string& title) {
  return fmt::format("set multiplot {} title {} noenhanced font ',14'\nset format x ''\n", layout,
                     GnuplotQuoted(title));
}

std::string AxisName(const std::string& name) {
  return fmt::format("set label {} at graph -0.08, 0.5 center rotate\n", GnuplotQuoted(name));
}

}  // namespace kestrel::records
