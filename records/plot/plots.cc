// SPDX-License-Identifier: Apache-2.0
#include "records/plot/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/file/files.h"
#include "base/process/piped_process.h"
#include "geometry/tait_bryan.h"
#include "mission/mission_type.h"
#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"

namespace kestrel::records {
namespace {

Eigen::Vector3d None3() { return Eigen::Vector3d::Constant(kNone); }

// One frame as it is drawn; without a fix its numbers are NaN, which gnuplot leaves out.
struct Sample {
  double t_s = 0;
  // x and y of the frame of the figures, height above it, m
  Eigen::Vector3d truth, fix = None3(), estimate = None3(), setpoint = None3();
  Eigen::Vector3d error = None3();  // of the fix: x, y, z of that frame, m
  double yaw_error_deg = kNone;
  // Against that frame, without leaps.
  double yaw_deg = 0, fix_yaw_deg = kNone, estimate_yaw_deg = kNone, setpoint_yaw_deg = kNone;
  double distance_m = 0;
};

Eigen::Vector3d HeightUp(const Eigen::Vector3d& p_T) { return {p_T.x(), p_T.y(), -p_T.z()}; }

// The frame of the figures: the pad's; without one its axes are those of N, over the place of the pad.
Pose FigureFrame(const Truth& truth, const PlotOptions& options) {
  if (options.pad_size_m) return truth.X_NT;
  return {Eigen::Quaterniond::Identity(), {truth.X_NT.p.x(), truth.X_NT.p.y(), 0}};
}

// The angle that is a whole number of turns from this one, and nearest to another.
double NearestTurn_deg(double angle_rad, double to_deg) {
  return to_deg + Degrees(WrapAngle(angle_rad - Radians(to_deg)));
}

std::vector<Sample> SamplesOf(const std::vector<LogRow>& rows, const PlotOptions& options) {
  std::vector<Sample> samples;
  for (const LogRow& row : rows) {
    const Pose X_TN = FigureFrame(row.exposure, options).Inverse();
    const Pose X_TB = X_TN * row.exposure.X_NB;
    const Pose X_NT = FigureFrame(row.now, options);
    Sample s;
    s.t_s = row.exposure.t_s;
    s.truth = HeightUp(X_TB.p);
    if (row.heard) s.estimate = HeightUp(X_NT.Inverse() * row.estimate.p_NB);
    s.distance_m = X_TB.p.head<2>().norm();
    s.yaw_deg = NearestTurn_deg(YawOf(X_TB.R), samples.empty() ? 0 : samples.back().yaw_deg);
    if (row.heard)
      s.estimate_yaw_deg = NearestTurn_deg(YawOf(X_NT.R.conjugate() * row.estimate.R_NB), s.yaw_deg);
    const auto* position =
        row.decision.setpoint ? std::get_if<control::PositionSetpoint>(&*row.decision.setpoint) : nullptr;
    if (position) {
      s.setpoint = HeightUp(X_NT.Inverse() * position->p_N);
      s.setpoint_yaw_deg = NearestTurn_deg(position->yaw - YawOf(X_NT.R), s.yaw_deg);
    }
    if (const auto& fix = row.decision.fix) {
      s.fix = HeightUp(fix->p_TB);
      s.error = fix->p_TB - X_TB.p;
      s.yaw_error_deg = Degrees(WrapAngle(fix->yaw_TB - YawOf(X_TB.R)));
      s.fix_yaw_deg = s.yaw_deg + s.yaw_error_deg;
    }
    samples.push_back(s);
  }
  return samples;
}

std::string Data(const std::vector<Sample>& samples, const std::vector<LogRow>& rows) {
  std::string text = "$flight << END_OF_FLIGHT\n";
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    text += fmt::format(
        "{:.4f} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.4f} {:.6g} {:.6g} {:.6g} "
        "{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n",
        s.t_s, s.truth.x(), s.truth.y(), s.truth.z(), s.fix.x(), s.fix.y(), s.fix.z(), rows[i].now.t_s,
        s.estimate.x(), s.estimate.y(), s.estimate.z(), s.error.x(), s.error.y(), s.error.z(),
        s.yaw_error_deg, s.distance_m, s.yaw_deg, s.fix_yaw_deg, s.estimate_yaw_deg, s.setpoint.x(),
        s.setpoint.y(), s.setpoint.z(), s.setpoint_yaw_deg);
  }
  return text + "END_OF_FLIGHT\n";
}

constexpr const char* kFourPanels = "layout 4,1 margins 0.09,0.97,0.06,0.91 spacing 0,0.03";
constexpr const char* kFivePanels = "layout 5,1 margins 0.09,0.97,0.05,0.93 spacing 0,0.025";

std::string Position(const std::filesystem::path& file, const std::vector<Sample>& samples,
                     const std::vector<LogRow>& rows, const PlotOptions& options, bool fixes) {
  static constexpr const char* kOfPad[] = {"x of the pad (m)", "y of the pad (m)", "height above the pad (m)",
                                           "yaw (°)"};
  static constexpr const char* kOfGround[] = {"north (m)", "east (m)", "height (m)", "yaw (°)"};
  std::string text =
      BeginFigure(file, 1200, 1300) +
      BeginPanels(kFourPanels,
                  (options.pad_size_m ? "Position in the frame of the pad: " : "Position: ") + options.title);
  text += "set xrange " + TimeRange(rows) + '\n';
  const bool sent = std::any_of(samples.begin(), samples.end(),
                                [](const Sample& s) { return !std::isnan(s.setpoint_yaw_deg); });
  const bool estimated = std::any_of(samples.begin(), samples.end(),
                                     [](const Sample& s) { return !std::isnan(s.estimate_yaw_deg); });
  constexpr int kYaw = 3;
  for (int axis = 0; axis <= kYaw; ++axis) {
    Span span;
    for (const Sample& s : samples) {
      if (axis == kYaw)
        for (const double each : {s.yaw_deg, s.fix_yaw_deg, s.estimate_yaw_deg, s.setpoint_yaw_deg})
          span.Add(each);
      else
        for (const Eigen::Vector3d& each : {s.truth, s.fix, s.estimate, s.setpoint}) span.Add(each[axis]);
    }
    const int truth = axis == kYaw ? 17 : 2 + axis, fix = axis == kYaw ? 18 : 5 + axis,
              estimate = axis == kYaw ? 19 : 9 + axis, setpoint = 20 + axis;  // columns
    text += PhaseLines(rows, axis == 0);
    if (axis == kYaw) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += AxisName((options.pad_size_m ? kOfPad : kOfGround)[axis]) + (axis == 0 ? kKey : "unset key\n");
    text += fmt::format("set yrange {}\nplot ", span.Range(axis == kYaw ? 4 : 0.5));
    if (sent) text += fmt::format("$flight using 8:{} with {} title 'setpoint', ", setpoint, kSetpointStyle);
    if (estimated)
      text += fmt::format("$flight using 8:{} with {} title 'autopilot', ", estimate, kEstimateStyle);
    if (fixes) text += fmt::format("$flight using 1:{} with {} title 'vision fix', ", fix, kSeenStyle);
    text += fmt::format("$flight using 1:{} with {} title 'truth'\n", truth, kTruthStyle);
  }
  return text + EndFigure();
}

std::string Error(const std::filesystem::path& file, const std::vector<Sample>& samples,
                  const std::vector<LogRow>& rows, const mission::FigureText& figure) {
  struct Panel {
    const char* name;
    int column;
    double least;
    std::vector<std::string> metrics;
    Span span = {};
  };
  Panel panels[] = {
      {"x, error (m)", 12, 0.02, {"fix_x_rmse_m"}},
      {"y, error (m)", 13, 0.02, {"fix_y_rmse_m"}},
      {"z (down), error (m)", 14, 0.02, {"fix_z_rmse_m"}},
      {"yaw, error (°)", 15, 0.5, {"fix_yaw_rmse_deg"}},
      {"horizontal distance (m)", 16, 0.5, {"touchdown_error_m", "rest_error_m", "hold_horizontal_rmse_m"}}};
  for (const Sample& s : samples) {
    for (int axis = 0; axis < 3; ++axis) panels[axis].span.Add(s.error[axis]);
    panels[3].span.Add(s.yaw_error_deg);
    panels[4].span.Add(s.distance_m);
  }
  panels[4].span.Add(0);
  std::string text =
      BeginFigure(file, 1200, 1500) +
      BeginPanels(kFivePanels,
                  "Error of the vision fix (fix less truth), and distance from the pad: " + figure.title);
  text += "set xrange " + TimeRange(rows) + "\nset xzeroaxis lc rgb '#888888'\nunset key\n";
  for (Panel& panel : panels) {
    const bool first = &panel == panels, last = panel.column == 16;
    text +=
        PhaseLines(rows, first) + AxisName(panel.name) + LimitLines(figure, panel.metrics, panel.span, !last);
    if (last) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += fmt::format("set yrange {}\nplot $flight using 1:{} with {}\n", panel.span.Range(panel.least),
                        panel.column, last ? kTruthStyle : kSeenStyle);
  }
  return text + EndFigure();
}

// The pad's outline and what else flies, as data, and as parts of the plot; of those only what lies within
// the spans.
struct Surroundings {
  std::string data, plots;
};

Surroundings SurroundingsOf(const std::vector<LogRow>& rows, const PlotOptions& options, Span& x, Span& y,
                            Span& height) {
  Surroundings s;
  if (options.pad_size_m) {
    const Eigen::Vector2d half = *options.pad_size_m / 2;
    x.Add(-half.x()), x.Add(half.x()), y.Add(-half.y()), y.Add(half.y());
    s.data += "$pad << END_OF_PAD\n";
    for (const auto& [sx, sy] : {std::pair{1, 1}, {1, -1}, {-1, -1}, {-1, 1}, {1, 1}})
      s.data += fmt::format("{} {}\n", sy * half.y(), sx * half.x());
    s.data += "END_OF_PAD\n";
    s.plots += "$pad using 1:2:(0) with lines lw 3 lc rgb '#999999' title 'pad', ";
  }
  const std::size_t targets = rows.front().now.targets.size();
  std::vector<std::vector<Eigen::Vector3d>> paths(targets);
  for (std::size_t i = 0; i < targets; ++i)
    for (const LogRow& row : rows)
      paths[i].push_back(HeightUp(FigureFrame(row.now, options).Inverse() * row.now.targets[i].p_N));
  const double reach = std::max({x.size(), y.size(), 10.0});
  const Span near_x{x.middle() - reach, x.middle() + reach}, near_y{y.middle() - reach, y.middle() + reach};
  const auto near = [&](const Eigen::Vector3d& p) { return near_x.Holds(p.x()) && near_y.Holds(p.y()); };
  for (std::size_t i = 0; i < targets; ++i) {
    s.data += fmt::format("$target{} << END_OF_TARGET\n", i);
    for (const Eigen::Vector3d& p : paths[i]) {
      if (near(p)) x.Add(p.x()), y.Add(p.y()), height.Add(p.z());
      s.data += fmt::format("{:.6g} {:.6g} {:.6g}\n", near(p) ? p.y() : kNone, p.x(), p.z());
    }
    s.data += "END_OF_TARGET\n";
    s.plots += fmt::format(
        "$target{0} using 1:2:3 with lines lw 2 lc rgb '{1}' title 'target {0}', "
        "'' every ::0::0 using 1:2:3 with points pt 7 ps 1.2 lc rgb '{1}', ",
        i, TargetColour(i));
  }
  return s;
}

// Some arrows along the flight, to where the nose points: $heading, by the truth and, where it is not none,
// by the fix, each as right, forward, up and the arrow along them.
std::string HeadingData(const std::vector<Sample>& samples, double length_m) {
  constexpr std::size_t kArrows = 24;
  std::string text = "$heading << END_OF_HEADING\n";
  for (std::size_t i = 0; i < samples.size(); i += std::max<std::size_t>(1, samples.size() / kArrows)) {
    const Sample& s = samples[i];
    for (const auto& [p, yaw_deg] : {std::pair{s.truth, s.yaw_deg}, {s.fix, s.fix_yaw_deg}})
      text += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} ", p.y(), p.x(), p.z(),
                          length_m * std::sin(Radians(yaw_deg)), length_m * std::cos(Radians(yaw_deg)));
    text += '\n';
  }
  return text + "END_OF_HEADING\n";
}

std::string Trajectory(const std::filesystem::path& file, const std::vector<Sample>& samples,
                       const std::vector<LogRow>& rows, const PlotOptions& options, bool fixes) {
  Span x, y, height;
  height.Add(0);
  for (const Sample& s : samples) x.Add(s.truth.x()), y.Add(s.truth.y()), height.Add(s.truth.z());
  const Surroundings about = SurroundingsOf(rows, options, x, y, height);
  // Right, forward, up: so that turning right looks like it.
  std::string text = BeginFigure(file, 1200, 1000) + about.data +
                     HeadingData(samples, 0.07 * std::max({x.size(), y.size(), 1.0}));
  const std::string fix_headings =
      fixes ? "$heading using 6:7:8:9:10:(0) with vectors filled head lw 1.4 lc rgb '#E69F00' "
              "title 'heading by the fix', "
            : "";
  const Eigen::Vector3d &start = samples.front().truth, &end = samples.back().truth;
  text += fmt::format(
      "$start << END_OF_START\n{} {} {}\nEND_OF_START\n$end << END_OF_END\n{} {} "
      "{}\nEND_OF_END\n",
      start.y(), start.x(), start.z(), end.y(), end.x(), end.z());
  text += fmt::format(
      "set label 1 {} at screen 0.5, 0.965 center noenhanced font ',14'\nset border 895 lc rgb '#bbbbbb'\n"
      "set tics textcolor rgb '#333333'\n"
      "set xyplane at 0\nset view 62,35,1.12,1.0\nset view equal xy\nset grid xtics ytics ztics vertical\n"
      "set xrange {}\nset yrange {}\nset zrange [0:{:.6g}]\nset xtics {}\nset ytics {}\nset ztics {}\n"
      "set xlabel '{}' rotate parallel offset 0,-1\n"
      "set ylabel '{}' rotate parallel offset 0,-1\n"
      "set zlabel 'height (m)' rotate parallel\n"
      "set key at screen 0.03, 0.93 left top vertical Left reverse noautotitle\n",
      GnuplotQuoted("True trajectory: " + options.title), y.Range(1.0), x.Range(1.0),
      1.06 * std::max(height.high, 0.5), TickStep(y, 1.0), TickStep(x, 1.0), TickStep(height, 0.5),
      options.pad_size_m ? "y of the pad, right (m)" : "east (m)",
      options.pad_size_m ? "x of the pad, forward (m)" : "north (m)");
  return text +
         "splot $flight using 3:2:(0) with lines lw 1.5 lc rgb '#bbbbbb' title 'track on the ground', " +
         about.plots +
         "$flight using 3:2:4 with lines lw 2.5 lc rgb '#222222' title 'aircraft', "
         "$heading using 1:2:3:4:5:(0) with vectors filled head lw 1.4 lc rgb '#222222' title 'heading', " +
         fix_headings +
         "$start using 1:2:3 with points pt 7 ps 2 lc rgb '#222222' title 'start', "
         "$end using 1:2:3 with points pt 9 ps 2 lc rgb '#222222' title 'end'\n" +
         EndFigure();
}

struct Plot {
  std::filesystem::path file;
  std::string script;
};

// By one gnuplot, which is the fastest. Where it fails, one by one: a plot that cannot be drawn takes none of
// the others along, and is named.
void DrawAll(const std::vector<Plot>& plots, const std::string& data) {
  try {
    PipedProcess gnuplot({"gnuplot", "-d"});
    gnuplot.Write(data);
    for (const Plot& each : plots) gnuplot.Write(each.script);
    gnuplot.Close();
    for (const Plot& each : plots) RequireWholePng(each.file);
    for (const Plot& each : plots) Complete(each.file);
    return;
  } catch (const std::runtime_error&) {}
  std::string errors;
  for (const Plot& each : plots) {
    try {
      RunGnuplot(each.file, data + each.script);
    } catch (const std::runtime_error& e) {
      errors += fmt::format("{}{}", errors.empty() ? "" : "; ", e.what());
    }
  }
  if (!errors.empty()) throw std::runtime_error(errors);
}

}  // namespace

std::vector<std::string> PlotNames() {
  std::vector<std::string> names = {"position.png", "error.png", "trajectory.png", "flown.png"};
  for (const mission::Flight& each : mission::Missions())
    for (const mission::MissionPlot& plot : each.type().plots)
      if (std::find(names.begin(), names.end(), plot.file) == names.end()) names.push_back(plot.file);
  return names;
}

void DrawPlots(const std::filesystem::path& folder, const std::vector<LogRow>& rows,
               const PlotOptions& options) {
  if (rows.empty()) return;
  const std::vector<Sample> samples = SamplesOf(rows, options);
  const auto any = [&rows](auto&& has) { return std::any_of(rows.begin(), rows.end(), has); };
  const bool fix = any([](const LogRow& row) { return row.decision.fix.has_value(); });
  const mission::FigureText figure{options.title, options.limits};
  std::vector<Plot> plots;
  const auto add = [&](const std::string& name, auto&& script) {
    plots.push_back({folder / name, script(folder / name)});
  };
  add("position.png", [&](const auto& file) { return Position(file, samples, rows, options, fix); });
  add("trajectory.png", [&](const auto& file) { return Trajectory(file, samples, rows, options, fix); });
  if (fix || (options.pad_size_m && (!options.mission || options.mission->looks_for_pad)))
    add("error.png", [&](const auto& file) { return Error(file, samples, rows, figure); });
  if (options.mission)
    for (const mission::MissionPlot& plot : options.mission->plots)
      if (plot.has_data(rows))
        add(plot.file, [&](const auto& file) { return plot.script(file, rows, figure); });
  DrawAll(plots, Data(samples, rows));
}

}  // namespace kestrel::records
