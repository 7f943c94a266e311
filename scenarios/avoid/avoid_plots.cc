// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/avoid_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "geometry/tait_bryan.h"
#include "records/plot/plot_parts.h"
#include "scenarios/avoid/avoid_metrics.h"
#include "scenarios/avoid/avoid_report.h"

namespace kestrel::scenarios {
namespace {

constexpr int kHeight_px = 1000;
constexpr double kPlanTop = 0.90, kPlanBottom = 0.07;  // shares of the figure
constexpr double kLeft_px = 70, kGap_px = 120, kPanels_px = 680, kRight_px = 30;
constexpr double kNarrowest_px = 330, kWidest_px = 830;  // the plan
constexpr const char* kHeldStyle = "lines lw 2.5 dt (6,3) lc rgb '#009E73'";
constexpr double kHeadings = 45;  // at most so many are drawn

struct PhaseLook {
  std::string_view name;
  const char *colour, *shade;
};
constexpr PhaseLook kPhases[] = {{"cruise", "#222222", "#ffffff"},
                                 {"avoid", "#332288", "#e6e3f2"},
                                 {"pass", "#999933", "#f2f2dd"},
                                 {"return", "#56B4E9", "#e2f1fb"}};

const PhaseLook& LookOf(std::string_view phase) {
  const auto found = std::find_if(std::begin(kPhases), std::end(kPhases),
                                  [&](const PhaseLook& l) { return l.name == phase; });
  return found != std::end(kPhases) ? *found : kPhases[0];
}

std::string RgbOf(const PhaseLook& look) { return fmt::format("0x{}", look.colour + 1); }

// What of the map is drawn, with one scale, and how wide that makes the plan.
struct Map {
  records::Span east, north;
  double width_px = 0;
};

Map MapOf(const std::vector<records::LogRow>& rows, const Eigen::Vector2d& course_end_N,
          const Closest& closest) {
  records::Span east, north;
  const auto add = [&](const Eigen::Vector2d& p_N) { north.Add(p_N.x()), east.Add(p_N.y()); };
  add(course_end_N);
  for (const records::LogRow& row : rows) add(row.now.X_NB.p.head<2>());
  // What flies away must not make the encounter small.
  const double reach = 0.5 * std::max({east.size(), north.size(), 4.0});
  const records::Span near_east{east.middle() - reach, east.middle() + reach},
      near_north{north.middle() - reach, north.middle() + reach};
  for (const records::LogRow& row : rows)
    for (const TargetTruth& target : row.now.targets)
      if (near_east.Holds(target.p_N.y()) && near_north.Holds(target.p_N.x())) add(target.p_N.head<2>());

  const Eigen::Vector2d corner = Eigen::Vector2d::Constant(closest.distance_m);  // of the circle's square
  if (closest.distance_m < reach)
    add(closest.target_N.head<2>() - corner), add(closest.target_N.head<2>() + corner);

  const double height_px = kHeight_px * (kPlanTop - kPlanBottom);
  const double wide_m = 1.15 * std::max(east.size(), 0.5), high_m = 1.1 * std::max(north.size(), 0.5);
  const double width_px = std::clamp(height_px * wide_m / high_m, kNarrowest_px, kWidest_px);
  const double m_per_px = std::max(wide_m / width_px, high_m / height_px);
  const auto about = [](const records::Span& span, double size) {
    return records::Span{span.middle() - size / 2, span.middle() + size / 2};
  };
  return {about(east, m_per_px * width_px), about(north, m_per_px * height_px), width_px};
}

// Whole seconds between the headings that are drawn.
double InstantStep(double all_s) {
  for (const double step : {1, 2, 5, 10, 20, 50})
    if (all_s / step <= kHeadings) return step;
  return 100;
}

double BearingOf(const Truth& truth, const TargetTruth& target) {
  const Eigen::Vector3d p = target.p_N - truth.X_NB.p;
  return WrapAngle(std::atan2(p.y(), p.x()) - YawOf(truth.X_NB.R));
}

// Columns: time, north, east, colour of the phase, bearing seen, bearing held, range seen, yaw rate; then of
// each target north, east, distance and bearing.
std::string FlightData(const std::vector<records::LogRow>& rows) {
  std::string text = "$encounter << END_OF_ENCOUNTER\n";
  std::vector<double> last(rows.front().now.targets.size(), records::kNone);
  for (const records::LogRow& row : rows) {
    const Encounter* other = EncounterOf(row.decision);
    const auto* command =
        row.decision.setpoint ? std::get_if<control::VelocitySetpoint>(&*row.decision.setpoint) : nullptr;
    text += fmt::format("{:.4f} {:.6g} {:.6g} {} {:.6g} {:.6g} {:.6g} {:.6g}", row.now.t_s,
                        row.now.X_NB.p.x(), row.now.X_NB.p.y(), RgbOf(LookOf(row.decision.phase)),
                        other ? Degrees(other->azimuth) : records::kNone,
                        other && other->wanted ? Degrees(*other->wanted) : records::kNone,
                        other ? other->range_m.value_or(records::kNone) : records::kNone,
                        command ? Degrees(command->yaw_rate) : records::kNone);
    for (std::size_t i = 0; i < row.now.targets.size(); ++i) {
      const TargetTruth& target = row.now.targets[i];
      const double bearing = BearingOf(row.now, target);
      const bool wraps = std::abs(bearing - last[i]) > M_PI;  // no line across the figure
      last[i] = bearing;
      text += fmt::format(" {:.6g} {:.6g} {:.6g} {:.6g}", target.p_N.x(), target.p_N.y(),
                          (target.p_N - row.now.X_NB.p).norm(), wraps ? records::kNone : Degrees(bearing));
    }
    text += '\n';
  }
  return text + "END_OF_ENCOUNTER\n";
}

// The heading as an arrow of a length, m, at regular instants, and where each target was then; every fifth
// with its time, of a target only once it has moved on.
std::string InstantData(const std::vector<records::LogRow>& rows, double arrow_m) {
  const double step = InstantStep(rows.back().now.t_s - rows.front().now.t_s);
  const std::size_t targets = rows.front().now.targets.size();
  std::string headings = "$headings << END_OF_HEADINGS\n", times;
  std::vector<std::string> marks(targets);
  std::vector<Eigen::Vector3d> told;  // where a time was last written
  for (const TargetTruth& target : rows.front().now.targets) told.push_back(target.p_N);
  double next_s = std::ceil(rows.front().now.t_s / step) * step;
  for (const records::LogRow& row : rows) {
    if (row.now.t_s < next_s) continue;
    const bool tells = std::fmod(std::round(next_s / step), 5) == 0;
    const std::string name = tells ? fmt::format("{:g} s", next_s) : "";
    next_s += step;
    const Eigen::Vector3d& p = row.now.X_NB.p;
    const double yaw = YawOf(row.now.X_NB.R);
    headings += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {}\n", p.y(), p.x(), arrow_m * std::sin(yaw),
                            arrow_m * std::cos(yaw), RgbOf(LookOf(row.decision.phase)));
    if (tells) times += fmt::format("{:.6g} {:.6g} \"{}\"\n", p.y(), p.x(), name);
    for (std::size_t i = 0; i < targets; ++i) {
      const Eigen::Vector3d& at = row.now.targets[i].p_N;
      const bool moved = (at - told[i]).norm() > 2 * arrow_m;
      marks[i] += fmt::format("{:.6g} {:.6g} \"{}\"\n", at.y(), at.x(), tells && moved ? name : "");
      if (tells && moved) told[i] = at;
    }
  }
  std::string text = headings + "END_OF_HEADINGS\n$times << END_OF_TIMES\n" + times + "END_OF_TIMES\n";
  for (std::size_t i = 0; i < targets; ++i)
    text += fmt::format("$marks{} << END_OF_MARKS\n{}END_OF_MARKS\n", i, marks[i]);
  return text;
}

// Where the course ends, as far as it was flown.
Eigen::Vector2d CourseEnd(const std::vector<records::LogRow>& rows) {
  const double course = YawOf(rows.front().estimate.R_NB);
  const Eigen::Vector2d along(std::cos(course), std::sin(course)), begin = rows.front().now.X_NB.p.head<2>();
  double flown_m = 0;
  for (const records::LogRow& row : rows)
    flown_m = std::max(flown_m, (row.now.X_NB.p.head<2>() - begin).dot(along));
  return begin + flown_m * along;
}

std::string Plan(const std::vector<records::LogRow>& rows, const Map& map, const Closest& closest,
                 double width_px) {
  const Eigen::Vector2d begin = rows.front().now.X_NB.p.head<2>(), end = CourseEnd(rows);
  std::string text = fmt::format(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {}\n"
      "set bmargin at screen {}\nset xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n"
      "set xlabel 'east (m)'\nset ylabel 'north (m)' offset 1,0\nset format '%g'\nset xtics {}\nset ytics "
      "{}\n",
      kLeft_px / width_px, (kLeft_px + map.width_px) / width_px, kPlanTop, kPlanBottom, map.east.low,
      map.east.high, map.north.low, map.north.high, records::TickStep(map.east, 0.5),
      records::TickStep(map.north, 0.5));
  text += fmt::format(
      "set arrow from {:.6g},{:.6g} to {:.6g},{:.6g} nohead back lw 1.2 dt (10,6) lc rgb '#888888'\n"
      "set object circle at {:.6g},{:.6g} size {:.6g} fs empty border lc rgb '{}' lw 1.2\n",
      begin.y(), begin.x(), end.y(), end.x(), closest.target_N.y(), closest.target_N.x(), closest.distance_m,
      records::TargetColour(closest.target));
  text += fmt::format(
      "set key at screen {:.5f}, 0.955 left top horizontal noautotitle samplen 2 width 1 maxrows 1\n",
      kLeft_px / width_px);
  text += "plot ";
  for (std::size_t i = 0; i < rows.front().now.targets.size(); ++i) {
    text += fmt::format(
        "$encounter using {0}:{1} with lines lw 1.5 lc rgb '{2}', "
        "$marks{3} using 1:2 with points pt 7 ps 0.7 lc rgb '{2}', "
        "'' using 1:2:3 with labels right offset -0.6,-0.7 font ',9' tc rgb '{2}', ",
        10 + 4 * i, 9 + 4 * i, records::TargetColour(i), i);
  }
  text +=
      "$encounter using 3:2:4 with lines lw 2.5 lc rgb variable, "
      "$headings using 1:2:3:4:5 with vectors head size screen 0.006,25 filled lw 1.4 lc rgb variable, "
      "$times using 1:2:3 with labels left offset 1.4,0 font ',9' tc rgb '#555555'";
  for (const PhaseLook& look : kPhases)
    text += fmt::format(", keyentry with lines lw 2.5 lc rgb '{}' title '{}'", look.colour, look.name);
  return text + "\nunset arrow\nunset object\nunset label\nset autoscale x\n";
}

std::string Panels(const std::vector<records::LogRow>& rows, const Map& map, const Closest& closest,
                   double width_px, const mission::FigureText& figure) {
  const std::size_t targets = rows.front().now.targets.size();
  const double left_px = kLeft_px + map.width_px + kGap_px;
  const double height = (kPlanTop - kPlanBottom - 0.07) / 3;
  std::string text = fmt::format(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset xrange {}\nset format x ''\n"
      "set xtics autofreq\nset xlabel ''\n",
      left_px / width_px, (left_px + kPanels_px) / width_px, records::TimeRange(rows));
  text += records::Shades(rows, [](const records::LogRow& row) { return LookOf(row.decision.phase).shade; });
  const auto panel = [&](int row, const char* name, const std::string& range) {
    const double top = kPlanTop - row * (height + 0.035);
    text += fmt::format(
        "set tmargin at screen {:.5f}\nset bmargin at screen {:.5f}\nset ylabel '{}'\n"
        "set yrange {}\nset ytics autofreq\n",
        top, top - height, name, range);
  };

  records::Span distance, bearing, yaw_rate;
  distance.Add(0), yaw_rate.Add(0);
  for (const records::LogRow& row : rows) {
    for (const TargetTruth& target : row.now.targets) {
      distance.Add((target.p_N - row.now.X_NB.p).norm());
      bearing.Add(Degrees(BearingOf(row.now, target)));
    }
    if (const Encounter* other = EncounterOf(row.decision)) {
      bearing.Add(Degrees(other->azimuth));
      if (other->wanted) bearing.Add(Degrees(*other->wanted));
    }
    if (!row.decision.setpoint) continue;
    if (const auto* command = std::get_if<control::VelocitySetpoint>(&*row.decision.setpoint))
      yaw_rate.Add(Degrees(command->yaw_rate));
  }
  text += records::LimitLines(figure, {"closest_m"}, distance);
  panel(0, "distance (m)", fmt::format("[0:{:.6g}]", 1.06 * std::max(distance.high, 1.0)));
  text += fmt::format(
      "set key at screen {:.5f}, 0.955 right top horizontal noautotitle samplen 2 width 1 maxrows 1\n"
      "set label '{:.2f} m' at {:.4f}, {:.6g} point pt 6 ps 1.6 lw 2 lc rgb '{}' offset 0,1.2 center\n"
      "plot $encounter using 1:7 with points pt 7 ps 0.4 lc rgb '#E69F00' title 'vision', ",
      (left_px + kPanels_px) / width_px, closest.distance_m, closest.t_s, closest.distance_m,
      records::TargetColour(closest.target));
  for (std::size_t i = 0; i < targets; ++i)
    text += fmt::format("'' using 1:{} with lines lw 1.8 lc rgb '{}' title 'target {}', ", 11 + 4 * i,
                        records::TargetColour(i), i);
  text += fmt::format("keyentry with {} title 'bearing to be held'\nunset key\nunset label\nunset arrow\n",
                      kHeldStyle);

  panel(1, "bearing (°)", bearing.Range(40));
  text +=
      "set xzeroaxis lc rgb '#888888'\n"
      "plot $encounter using 1:5 with points pt 7 ps 0.4 lc rgb '#E69F00'";
  for (std::size_t i = 0; i < targets; ++i)
    text +=
        fmt::format(", '' using 1:{} with lines lw 1.6 lc rgb '{}'", 12 + 4 * i, records::TargetColour(i));
  text += fmt::format(", '' using 1:6 with {}\n", kHeldStyle);

  panel(2, "yaw rate, asked for (°/s)", yaw_rate.Range(10));
  text +=
      "set format x '%g'\nset xlabel 'time (s)'\n"
      "plot $encounter using 1:8 with " +
      std::string(records::kSetpointStyle) + '\n';
  return text;
}

}  // namespace

std::string EncounterPlot(const std::filesystem::path& file, const std::vector<records::LogRow>& rows,
                          const mission::FigureText& figure) {
  const Closest closest = ClosestOf(rows);
  const Map map = MapOf(rows, CourseEnd(rows), closest);
  const double width_px = std::round(kLeft_px + map.width_px + kGap_px + kPanels_px + kRight_px);
  return FlightData(rows) + InstantData(rows, 0.025 * std::max(map.north.size(), map.east.size())) +
         records::BeginFigure(file, static_cast<int>(width_px), kHeight_px) +
         records::BeginPanels("", "Passing others: " + figure.title) + Plan(rows, map, closest, width_px) +
         Panels(rows, map, closest, width_px, figure) + records::EndFigure();
}

}  // namespace kestrel::scenarios
