// SPDX-License-Identifier: Apache-2.0
#include "scenarios/hand_held/hand_held_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"
#include "scenarios/hand_held/hand_held_report.h"

namespace kestrel::scenarios {
namespace {

using records::kNone;

constexpr const char* kChainStyle = "lines lw 1.4 dt (6,3) lc rgb '#882255'";

RoomPlace Nowhere() { return {Eigen::Vector3d::Constant(kNone), kNone}; }

// Of one row: the camera in the room.
struct Line {
  double t_s = 0;
  RoomPlace truth = Nowhere(), seen = Nowhere(), chained = Nowhere();
};

std::vector<Line> LinesOf(const std::vector<records::LogRow>& rows) {
  std::vector<Line> lines;
  for (const records::LogRow& row : rows) {
    const auto* report = mission::ReportOf<HandHeldReport>(row.decision);
    if (!report) continue;
    Line line{row.exposure.t_s, InRoom(TrueCamera(row.exposure, *report))};
    if (report->seen) line.seen = InRoom(SeenCamera(row.exposure, *report->seen));
    if (report->chained) line.chained = InRoom(SeenCamera(row.exposure, *report->chained));
    lines.push_back(line);
  }
  return lines;
}

// Columns: time; x, y, z and yaw by the motion capture; by the landmark; by the chain.
std::string Data(const std::vector<Line>& lines) {
  std::string text = "$camera << END_OF_CAMERA\n";
  for (const Line& line : lines) {
    text += fmt::format("{:.4f}", line.t_s);
    for (const RoomPlace* place : {&line.truth, &line.seen, &line.chained})
      text += fmt::format(" {:.6g} {:.6g} {:.6g} {:.6g}", place->p.x(), place->p.y(), place->p.z(),
                          Degrees(place->yaw));
    text += '\n';
  }
  return text + "END_OF_CAMERA\n";
}

}  // namespace

bool SawLandmark(const std::vector<records::LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const records::LogRow& row) {
    const auto* report = mission::ReportOf<HandHeldReport>(row.decision);
    return report && report->seen;
  });
}

std::string HandHeldPlot(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                         const mission::FigureText& figure) {
  const std::vector<Line> lines = LinesOf(rows);
  const bool chained =
      std::any_of(lines.begin(), lines.end(), [](const Line& l) { return !std::isnan(l.chained.yaw); });
  std::string text = Data(lines) + records::BeginFigure(file, 1200, 1300) +
                     records::BeginPanels("layout 4,1 margins 0.09,0.97,0.06,0.92 spacing 0,0.03",
                                          "The camera in the room: " + figure.title) +
                     "set xrange " + records::TimeRange(rows) + '\n';
  constexpr const char* kNames[] = {"x, across (m)", "y, depth (m)", "z, up (m)", "yaw (°)"};
  for (int panel = 0; panel < 4; ++panel) {
    records::Span span;
    for (const Line& line : lines)
      for (const RoomPlace* place : {&line.truth, &line.seen, &line.chained})
        span.Add(panel < 3 ? place->p[panel] : Degrees(place->yaw));
    text += records::PhaseLines(rows, false) + records::AxisName(kNames[panel]) +
            (panel == 0 ? records::kKey : "unset key\n");
    if (panel == 3) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += fmt::format("set yrange {}\nplot ", span.Range(panel < 3 ? 0.2 : 4));
    if (chained)
      text += fmt::format("$camera using 1:{} with {} title 'chain alone', ", 10 + panel, kChainStyle);
    text +=
        fmt::format("$camera using 1:{} with {} title 'motion capture', ", 2 + panel, records::kTruthStyle);
    text += fmt::format("$camera using 1:{} with {} title 'landmark'\n", 6 + panel, records::kSeenStyle);
  }
  return text + records::EndFigure();
}

std::string HandHeldTrajectory(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                               const mission::FigureText& figure) {
  const std::vector<Line> lines = LinesOf(rows);
  const Eigen::Vector3d p_NT = rows.front().exposure.X_NT.p;
  records::Span x, y;
  x.Add(p_NT.y()), y.Add(p_NT.x());
  for (const Line& line : lines) {
    x.Add(line.truth.p.x()), y.Add(line.truth.p.y());
    x.Add(line.seen.p.x()), y.Add(line.seen.p.y());
  }
  // A score of arrows along the way.
  const std::size_t every = std::max<std::size_t>(1, lines.size() / 20);
  const double arrow_m = 0.08 * std::max(x.size(), y.size());
  std::string text = Data(lines) + "$heading << END_OF_HEADING\n";
  for (std::size_t i = 0; i < lines.size(); i += every) {
    for (const RoomPlace* place : {&lines[i].truth, &lines[i].seen})
      text += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} ", place->p.x(), place->p.y(),
                          -arrow_m * std::sin(place->yaw), arrow_m * std::cos(place->yaw));
    text += '\n';
  }
  text += fmt::format("END_OF_HEADING\n$landmark << END_OF_LANDMARK\n{} {}\nEND_OF_LANDMARK\n", p_NT.y(),
                      p_NT.x());
  text += records::BeginFigure(file, 1000, 1100);
  text += fmt::format(
      "set title {} noenhanced font ',14'\nset size ratio -1\nset xrange {}\nset yrange {}\n"
      "set xlabel 'x, across (m)'\nset ylabel 'y, depth (m)'\n"
      "set key outside bottom center horizontal noautotitle samplen 2\n",
      records::GnuplotQuoted("The way through the room: " + figure.title), x.Range(1.0), y.Range(1.0));
  return text +
         fmt::format(
             "plot $camera using 2:3 with {} title 'motion capture', "
             "$camera using 6:7 with {} title 'landmark', "
             "$heading using 1:2:3:4 with vectors filled head lw 1.4 lc rgb '#222222', "
             "$heading using 5:6:7:8 with vectors filled head lw 1.4 lc rgb '#E69F00' title 'heading', "
             "$landmark using 1:2 with points pt 5 ps 1.6 lc rgb '#999999' title 'the landmark'\n",
             records::kTruthStyle, records::kSeenStyle) +
         records::EndFigure();
}

}  // namespace kestrel::scenarios
