// SPDX-License-Identifier: Apache-2.0
#include "records/plot/flown_plot.h"

#include <fmt/format.h>

#include "control/safety/safety.h"
#include "geometry/tait_bryan.h"
#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"

namespace kestrel::records {
namespace {

Eigen::Vector3d VelocityOf(const std::optional<control::Setpoint>& setpoint) {
  const auto* velocity = setpoint ? std::get_if<control::VelocitySetpoint>(&*setpoint) : nullptr;
  return velocity ? velocity->v_H : Eigen::Vector3d::Constant(kNone);
}

// Columns: time; x, y and height over the pad by the camera; height by the autopilot; velocity asked for, and
// sent; roll and pitch.
std::string Data(const std::vector<LogRow>& rows, Span (&spans)[3]) {
  std::string text = "$flown << END_OF_FLIGHT\n";
  for (const LogRow& row : rows) {
    const double t_s = row.now.t_s;
    Eigen::Vector3d fix = Eigen::Vector3d::Constant(kNone);
    if (const auto& seen = row.decision.fix) fix = {seen->p_TB.x(), seen->p_TB.y(), -seen->p_TB.z()};
    const double height_m = row.heard ? -row.estimate.p_NB.z() : kNone;
    const Eigen::Vector3d asked = VelocityOf(row.decision.setpoint), sent = VelocityOf(row.sent);
    const TaitBryan angles = TaitBryanFromRotation(row.estimate.R_NB.toRotationMatrix());
    const double roll = row.heard ? Degrees(angles.roll) : kNone;
    const double pitch = row.heard ? Degrees(angles.pitch) : kNone;
    text += fmt::format("{:.4f} {:.6g} {:.6g} {:.6g} {:.6g}", t_s, fix.x(), fix.y(), fix.z(), height_m);
    for (const Eigen::Vector3d& v : {asked, sent})
      text += fmt::format(" {:.6g} {:.6g} {:.6g}", v.x(), v.y(), v.z());
    text += fmt::format(" {:.6g} {:.6g}\n", roll, pitch);
    for (const double each : {fix.x(), fix.y(), fix.z(), height_m}) spans[0].Add(each);
    for (const Eigen::Vector3d& v : {asked, sent})
      for (const double each : v) spans[1].Add(each);
    spans[2].Add(roll), spans[2].Add(pitch);
  }
  return text + "END_OF_FLIGHT\n";
}

std::string_view ShadeOf(const LogRow& row) {
  return row.reaction == control::NameOf(control::Reaction::kFly) ? "#ffffff" : "#fbe3e3";
}

}  // namespace

void DrawFlownPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                   const std::string& title) {
  if (rows.empty()) return;
  Span spans[3];
  for (Span& span : spans) span.Add(0);
  const std::string data = Data(rows, spans);
  constexpr const char* kColours[] = {"#D55E00", "#0072B2", "#009E73"};
  const auto line = [&](int column, int colour, const char* style, const std::string& name) {
    return fmt::format("using 1:{} with {} lc rgb '{}' title '{}'", column, style, kColours[colour], name);
  };
  std::string text = data + BeginFigure(file, 1200, 1100) +
                     BeginPanels("layout 3,1 margins 0.09,0.97,0.07,0.90 spacing 0,0.05", title) +
                     "set xrange " + TimeRange(rows) +
                     "\nset key inside right top horizontal noautotitle samplen 2\n";
  const auto panel = [&](int i, const char* axis, double least) {
    text += PhaseLines(rows, i == 0) + Shades(rows, ShadeOf) + AxisName(axis);
    if (i == 2) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += fmt::format("set yrange {}\nplot $flown ", spans[i].Range(least));
  };
  const char *seen = "points pt 7 ps 0.45", *thin = "lines lw 1.2 dt (4,4)", *thick = "lines lw 1.8";
  panel(0, "over the pad (m)", 0.5);
  text += line(2, 0, seen, "x") + ", '' " + line(3, 1, seen, "y") + ", '' " + line(4, 2, seen, "height") +
          ", '' using 1:5 with lines lw 1.6 lc rgb '#222222' title 'height, autopilot'\n";
  text += "set key at graph 1, 1.13 right top horizontal noautotitle samplen 2\n";
  panel(1, "velocity (m/s)", 0.2);
  text += line(9, 0, thick, "forward, sent") + ", '' " + line(10, 1, thick, "right, sent") + ", '' " +
          line(11, 2, thick, "down, sent") + ", '' " + line(6, 0, thin, "asked for") + ", '' " +
          line(7, 1, thin, "") + ", '' " + line(8, 2, thin, "") + '\n';
  panel(2, "roll and pitch (°)", 2.0);
  text += line(12, 0, thick, "roll") + ", '' " + line(13, 1, thick, "pitch") + '\n';
  RunGnuplot(file, text + EndFigure());
}

}  // namespace kestrel::records
