// SPDX-License-Identifier: Apache-2.0
#include "scenarios/servo/servo_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/servo/servo_report.h"
#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"

namespace kestrel::scenarios {
namespace {

const mission::ServoReport* ReportOf(const mission::LogRow& row) {
  return mission::ReportOf<mission::ServoReport>(row.decision);
}

// Time, error in px, distance from the goal and height in m, yaw off the goal's in degrees; then the corners.
std::string Data(const std::vector<mission::LogRow>& rows) {
  std::string data = "$servo << END_OF_SERVO\n";
  for (const mission::LogRow& row : rows) {
    const mission::ServoReport* report = ReportOf(row);
    const Pose X_TB = row.now.X_NT.Inverse() * row.now.X_NB;
    data += fmt::format("{:.4f} {:.6g} {:.6g} {:.6g} {:.6g}", row.now.t_s,
                        report ? report->error_px : records::kNone, (X_TB.p - *row.decision.goal_T).norm(),
                        -X_TB.p.z(), Degrees(WrapAngle(YawOf(X_TB.R) - row.decision.goal_yaw_TB)));
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d at = report ? report->corners_px[i] : Eigen::Vector2d::Constant(records::kNone);
      data += fmt::format(" {:.6g} {:.6g}", at.x(), at.y());
    }
    data += '\n';
  }
  return data + "END_OF_SERVO\n";
}

}  // namespace

bool HasServoed(const std::vector<mission::LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(),
                     [](const mission::LogRow& row) { return ReportOf(row) != nullptr; });
}

std::string ServoPlot(const std::filesystem::path& file, const std::vector<mission::LogRow>& rows,
                      const mission::FigureText& figure) {
  const auto first = std::find_if(rows.begin(), rows.end(), ReportOf);
  records::Span u, v;
  std::string goal = "$goal << END_OF_GOAL\n";
  for (const Eigen::Vector2d& wanted : ReportOf(*first)->wanted_px)
    goal += fmt::format("{:.6g} {:.6g}\n", wanted.x(), wanted.y());
  goal += "END_OF_GOAL\n";
  for (const mission::LogRow& row : rows)
    if (const mission::ServoReport* report = ReportOf(row))
      for (std::size_t i = 0; i < 4; ++i) {
        u.Add(report->corners_px[i].x()), u.Add(report->wanted_px[i].x());
        v.Add(report->corners_px[i].y()), v.Add(report->wanted_px[i].y());
      }
  std::string text = Data(rows) + goal + records::BeginFigure(file, 1500, 800) +
                     fmt::format("set multiplot title {} noenhanced font ',14'\n",
                                 records::GnuplotQuoted("Visual servoing: " + figure.title));
  const auto panel = [](double left, double right, double bottom, double top) {
    return fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset "
        "tmargin at screen {}\n",
        left, right, bottom, top);
  };
  text += panel(0.06, 0.52, 0.09, 0.91) +
          fmt::format(
              "set xlabel 'u (px)'\nset ylabel 'v (px)' offset 1,0\nset size ratio -1\n"
              "set xrange {}\nset yrange [{:.6g}:{:.6g}]\nset key top left noautotitle samplen 2\nplot ",
              u.Range(50), v.high + 25, v.low - 25);
  for (int i = 0; i < 4; ++i)
    text += fmt::format("$servo using {}:{} with lines lw 1.6 lc rgb '{}', ", 6 + 2 * i, 7 + 2 * i,
                        records::TargetColour(static_cast<std::size_t>(i)));
  text += "$goal using 1:2 with points pt 2 ps 2 lw 2 lc rgb '#009E73' title 'corners wanted'\n";
  text += "set size noratio\nset yrange [*:*]\nset xlabel ''\nset key top right\n";
  text += "set xrange " + records::TimeRange(rows) + '\n';
  text += panel(0.60, 0.97, 0.65, 0.91) + records::PhaseLines(rows, true) +
          "set ylabel 'error of the corners (px)' offset -0.5,0\nset format x ''\nplot $servo using 1:2 with "
          "points pt 7 "
          "ps 0.4 lc rgb '#E69F00'\n";
  text += panel(0.60, 0.97, 0.37, 0.62) + records::PhaseLines(rows, false) +
          "set ylabel 'true height, distance (m)' offset -0.5,0\nplot $servo using 1:4 with lines lw 1.6 lc "
          "rgb '#222222' "
          "title 'height', '' using 1:3 with lines lw 1.8 dt (6,4) lc rgb '#222222' title 'from the goal'\n";
  text += panel(0.60, 0.97, 0.09, 0.34) + records::PhaseLines(rows, false) +
          "set ylabel 'yaw off the goal (°)' offset -0.5,0\nset format x '%g'\nset xlabel 'time (s)'\n"
          "plot $servo using 1:5 with lines lw 1.6 lc rgb '#222222'\n";
  return text + records::EndFigure();
}

}  // namespace kestrel::scenarios
