// SPDX-License-Identifier: Apache-2.0
#include "records/plot/growth_plot.h"

#include <fmt/format.h>

#include <algorithm>

#include "mission/mosaic/mosaic_report.h"
#include "records/plot/plot_parts.h"

namespace kestrel::records {
namespace {

const mission::MosaicReport* ReportOf(const LogRow& row) {
  const auto* report = mission::ReportOf<mission::MosaicReport>(row.decision);
  return report && report->step ? report : nullptr;
}

}  // namespace

bool MakesMosaic(const std::vector<LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const LogRow& row) { return ReportOf(row) != nullptr; });
}

std::string GrowthPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                       const mission::FigureText& figure) {
  // Columns: time, images, keyframes, loops, places that agree, their rms, moved.
  std::string text = "$growth << END_OF_GROWTH\n";
  Span residual;
  residual.Add(0);
  for (const LogRow& row : rows)
    if (const auto* report = ReportOf(row)) {
      const bool placed = vision::IsPlaced(report->step->state);
      if (placed) residual.Add(report->step->rms_px);
      text += fmt::format("{:.4f} {} {} {} {} {:.4g} {:.4g}\n", row.exposure.t_s, report->placed,
                          report->keyframes, report->loops, report->step->agreed,
                          placed ? report->step->rms_px : kNone,
                          report->step->adjusted ? report->step->moved_px : kNone);
    }
  const std::string limits = LimitLines(figure, {"mosaic_rms_px"}, residual);
  text +=
      "END_OF_GROWTH\n" + BeginFigure(file, 1200, 1000) +
      BeginPanels("layout 4,1 margins 0.09,0.97,0.07,0.91 spacing 0,0.03", "The mosaic: " + figure.title) +
      "set xrange " + TimeRange(rows) + '\n';
  text += PhaseLines(rows, false) + AxisName("images") +
          "unset key\nplot $growth using 1:2 with lines lw 1.8 lc rgb '#222222'\n";
  text += PhaseLines(rows, false) + AxisName("keyframes, loops") +
          "set key at screen 0.97, 0.965 right top horizontal noautotitle samplen 2\n"
          "plot $growth using 1:3 with lines lw 1.8 lc rgb '#222222' title 'keyframes', "
          "'' using 1:4 with lines lw 1.8 lc rgb '#882255' title 'loops'\nunset key\n";
  text += PhaseLines(rows, false) + AxisName("residual (px)") + limits +
          fmt::format("set yrange [0:{:.6g}]\nplot $growth using 1:6 with {}\n",
                      1.08 * std::max(residual.high, 0.5), kSeenStyle);
  text += PhaseLines(rows, false) + AxisName("moved by the adjustment (px)") +
          "set yrange [0:*]\nset format x '%g'\nset xlabel 'time (s)'\n"
          "plot $growth using 1:7 with impulses lw 1.4 lc rgb '#222222'\n";
  return text + EndFigure();
}

}  // namespace kestrel::records
