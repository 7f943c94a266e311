// SPDX-License-Identifier: Apache-2.0
#include "scenarios/follow/follow_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "control/law/sphere_target.h"
#include "geometry/tait_bryan.h"
#include "records/plot/plot_parts.h"
#include "scenarios/follow/follow_report.h"

namespace kestrel::scenarios {
namespace {

constexpr const char* kWantedStyle = "steps lw 2 lc rgb '#009E73'";
constexpr const char* kMissingColour = "#f3e3e3";

// Of one row: u and diameter, px, and the commands, m/s and degrees per second.
struct Line {
  double t_s = 0;
  double true_u = records::kNone, u = records::kNone, wanted_u = records::kNone;
  double true_diameter = records::kNone, diameter = records::kNone, wanted_diameter = records::kNone;
  double ahead = records::kNone, down = records::kNone, yaw_rate_deg_s = records::kNone;
  bool followed = false;
};

// What is wanted stands while the balloon is lost, by the last word of the mission.
std::vector<Line> LinesOf(const std::vector<records::LogRow>& rows) {
  std::vector<Line> lines;
  const BalloonSight* last = nullptr;
  for (const records::LogRow& row : rows) {
    Line line;
    line.t_s = row.now.t_s;
    const auto* sight = SightOf(row.decision);
    line.followed = sight != nullptr;
    if (sight) {
      last = sight;
      line.u = sight->focal_px * sight->now.s.x(), line.diameter = sight->focal_px * sight->now.diameter;
    }
    if (last) {
      line.wanted_u = last->focal_px * last->wanted.s.x();
      line.wanted_diameter = last->focal_px * last->wanted.diameter;
    }
    if (last && !row.now.targets.empty() && row.now.targets.front().p_V.z() > 0) {
      const TargetTruth& balloon = row.now.targets.front();
      const control::SphereImage image = control::SphereImageOf(balloon.p_V, balloon.diameter_m);
      line.true_u = last->focal_px * image.s.x(), line.true_diameter = last->focal_px * image.diameter;
    }
    if (row.decision.setpoint) {
      if (const auto* command = std::get_if<control::VelocitySetpoint>(&*row.decision.setpoint)) {
        line.ahead = command->v_H.x(), line.down = command->v_H.z();
        line.yaw_rate_deg_s = Degrees(command->yaw_rate);
      }
    }
    lines.push_back(line);
  }
  return lines;
}

}  // namespace

bool FollowsBalloon(const std::vector<records::LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(),
                     [](const records::LogRow& row) { return SightOf(row.decision) != nullptr; });
}

std::string FollowPlot(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                       const mission::FigureText& figure) {
  const std::vector<Line> lines = LinesOf(rows);
  records::Span u, diameter, ahead, down, yaw_rate;
  ahead.Add(0), down.Add(0), yaw_rate.Add(0);
  std::string text = "$follow << END_OF_FOLLOW\n";
  for (const Line& l : lines) {
    text += fmt::format("{:.4f} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n", l.t_s,
                        l.true_u, l.u, l.wanted_u, l.true_diameter, l.diameter, l.wanted_diameter, l.ahead,
                        l.down, l.yaw_rate_deg_s);
    u.Add(l.u), u.Add(l.wanted_u), diameter.Add(l.diameter), diameter.Add(l.wanted_diameter);
    if (l.followed) u.Add(l.true_u), diameter.Add(l.true_diameter);  // once lost it may be anywhere
    ahead.Add(l.ahead), down.Add(l.down), yaw_rate.Add(l.yaw_rate_deg_s);
  }
  text += "END_OF_FOLLOW\n" + records::BeginFigure(file, 1200, 1400) +
          records::BeginPanels("layout 5,1 margins 0.09,0.97,0.055,0.925 spacing 0,0.028",
                               "Following a balloon by its image: " + figure.title) +
          "set xrange " + records::TimeRange(rows) + '\n' +
          records::Shades(rows, [](const records::LogRow& row) {
            return SightOf(row.decision) ? "#ffffff" : kMissingColour;
          });

  const auto image = [&](const char* name, const records::Span& span, double least, int column, bool keyed) {
    text +=
        records::PhaseLines(rows, keyed) + records::AxisName(name) + (keyed ? records::kKey : "unset key\n");
    text += fmt::format("set yrange {}\nplot $follow using 1:{} with {} title 'vision', ", span.Range(least),
                        column + 1, records::kSeenStyle);
    text += fmt::format("'' using 1:{} with {} title 'truth', '' using 1:{} with {} title 'wanted'", column,
                        records::kTruthStyle, column + 2, kWantedStyle);
    if (keyed)
      text += fmt::format(", keyentry with boxes fs solid noborder fc rgb '{}' title 'none followed'",
                          kMissingColour);
    text += '\n';
  };
  image("u, right of the middle (px)", u, 20, 2, true);
  image("diameter (px)", diameter, 10, 5, false);

  text += "set xzeroaxis lc rgb '#888888'\n";
  const auto command = [&](const char* name, const records::Span& span, double least, int column) {
    text += records::PhaseLines(rows, false) + records::AxisName(name) +
            fmt::format("set yrange {}\nplot $follow using 1:{} with {}\n", span.Range(least), column,
                        records::kSetpointStyle);
  };
  command("ahead, asked for (m/s)", ahead, 0.2, 8);
  command("down, asked for (m/s)", down, 0.2, 9);
  text += "set format x '%g'\nset xlabel 'time (s)'\n";
  command("yaw rate, asked for (°/s)", yaw_rate, 10, 10);
  return text + records::EndFigure();
}

}  // namespace kestrel::scenarios
