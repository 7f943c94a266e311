// SPDX-License-Identifier: Apache-2.0
#include "records/plot/path_plot.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/tait_bryan.h"
#include "mission/path/path_pilot.h"
#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"

namespace kestrel::records {
namespace {

const mission::WaypointPath::Reference* ReferenceOf(const LogRow& row) {
  const auto* report = mission::ReportOf<mission::PathReport>(row.decision);
  return report && report->reference ? &*report->reference : nullptr;
}

}  // namespace

bool FliesPath(const std::vector<LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const LogRow& row) { return ReferenceOf(row) != nullptr; });
}

std::string PathPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                     const mission::FigureText& figure) {
  // Columns: time; east and north of the path, of the truth and of the autopilot; errors of place, height, yaw.
  std::string text = "$path << END_OF_PATH\n";
  Span east, north, off[3];
  off[0].Add(0);
  for (const LogRow& row : rows) {
    const auto* reference = ReferenceOf(row);
    if (!reference) continue;
    const Eigen::Vector3d &r = reference->p_N, &p = row.now.X_NB.p, &by_autopilot = row.estimate.p_NB;
    const double away[] = {(p - r).head<2>().norm(), r.z() - p.z(),
                           Degrees(WrapAngle(YawOf(row.now.X_NB.R) - reference->yaw))};
    for (int i = 0; i < 3; ++i) off[i].Add(away[i]);
    text += fmt::format("{:.4f} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n",
                        row.now.t_s, r.y(), r.x(), p.y(), p.x(), by_autopilot.y(), by_autopilot.x(), away[0],
                        away[1], away[2]);
    for (const Eigen::Vector3d* each : {&r, &p, &by_autopilot}) east.Add(each->y()), north.Add(each->x());
  }
  text += "END_OF_PATH\n" + BeginFigure(file, 1600, 900);
  text += fmt::format("set multiplot title {} font ',14' noenhanced\n",
                      GnuplotQuoted("The path, and the way that was flown: " + figure.title));
  text += fmt::format(
      "set lmargin at screen 0.07\nset rmargin at screen 0.47\nset bmargin at screen 0.08\n"
      "set tmargin at screen 0.9\nset size ratio -1\nset xrange {}\nset yrange {}\n"
      "set xlabel 'east (m)'\nset ylabel 'north (m)' offset 1,0\n"
      "set key at screen 0.47, 0.94 right top horizontal noautotitle samplen 2\n"
      "plot $path using 2:3 with lines lw 4 lc rgb '#009E73' title 'path to be flown', "
      "'' using 6:7 with {} title 'by the autopilot', '' using 4:5 with {} title 'flown'\n"
      "set size noratio\nset xrange {}\nunset key\nset lmargin at screen 0.56\nset rmargin at screen 0.98\n",
      east.Range(2), north.Range(2), kEstimateStyle, kTruthStyle, TimeRange(rows));
  struct Panel {
    const char* name;
    std::vector<std::string> metrics;
  };
  const Panel panels[] = {{"from the path (m)", {"path_horizontal_rmse_m"}},
                          {"above it (m)", {"path_vertical_rmse_m"}},
                          {"yaw off it (°)", {"path_yaw_rmse_deg"}}};
  for (int i = 0; i < 3; ++i) {
    const double top = 0.9 - 0.28 * i;
    const std::string limits = LimitLines(figure, panels[i].metrics, off[i], i > 0);
    text += PhaseLines(rows, i == 0) + limits +
            fmt::format("set tmargin at screen {:.3f}\nset bmargin at screen {:.3f}\n", top, top - 0.25) +
            fmt::format("set format x '{}'\nset xlabel '{}'\nset ylabel '{}'\nset yrange {}\n",
                        i == 2 ? "%g" : "", i == 2 ? "time (s)" : "", panels[i].name,
                        off[i].Range(i == 2 ? 2 : 0.2)) +
            fmt::format("plot $path using 1:{} with {}\n", 8 + i, kTruthStyle);
  }
  return text + EndFigure();
}

}  // namespace kestrel::records
