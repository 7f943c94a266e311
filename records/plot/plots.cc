// SPDX-License-Identifier: Apache-2.0
#include "records/plot/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/file/files.h"
#include "base/process/piped_program.h"
#include "geometry/tait_bryan.h"
#include "records/plot/gnuplot.h"
#include "records/plot/plot_parts.h"
#include "scenarios/avoid/avoid_metrics.h"
#include "scenarios/avoid/avoid_plots.h"
#include "scenarios/follow/follow_plots.h"

namespace kestrel {
namespace {

// One frame as it is drawn; without a fix its numbers are NaN, which gnuplot leaves out.
struct Sample {
  double t_s = 0;
  Eigen::Vector3d truth, fix, estimate;  // x and y of the frame of the figures, height above it, m
  Eigen::Vector3d error;                 // of the fix: x, y, z of that frame, m
  double yaw_error_deg = kNone;
  double distance_m = 0;
};

Eigen::Vector3d HeightUp(const Eigen::Vector3d& p_T) { return {p_T.x(), p_T.y(), -p_T.z()}; }

// The frame of the figures: the pad's; without one its axes are those of N.
Pose FigureFrame(const Truth& truth, const PlotOptions& options) {
  return options.pad_size_m ? truth.X_NT : Pose{Eigen::Quaterniond::Identity(), truth.X_NT.p};
}

std::vector<Sample> SamplesOf(const std::vector<LogRow>& rows, const PlotOptions& options) {
  std::vector<Sample> samples;
  for (const LogRow& row : rows) {
    const Pose X_TN = FigureFrame(row.exposure, options).Inverse();
    const Pose X_TB = X_TN * row.exposure.X_NB;
    Sample s{row.exposure.t_s,
             HeightUp(X_TB.p),
             Eigen::Vector3d::Constant(kNone),
             HeightUp(FigureFrame(row.now, options).Inverse() * row.estimate.p_NB),
             Eigen::Vector3d::Constant(kNone),
             kNone,
             X_TB.p.head<2>().norm()};
    if (const auto& fix = row.decision.fix) {
      s.fix = HeightUp(fix->p_TB);
      s.error = fix->p_TB - X_TB.p;
      s.yaw_error_deg = Degrees(WrapAngle(fix->yaw_TB - YawOf(X_TB.R)));
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
        "{:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n",
        s.t_s, s.truth.x(), s.truth.y(), s.truth.z(), s.fix.x(), s.fix.y(), s.fix.z(), rows[i].now.t_s,
        s.estimate.x(), s.estimate.y(), s.estimate.z(), s.error.x(), s.error.y(), s.error.z(),
        s.yaw_error_deg, s.distance_m);
  }
  return text + "END_OF_FLIGHT\n";
}

constexpr const char* kThreePanels = "layout 3,1 margins 0.09,0.97,0.07,0.90 spacing 0,0.035";

std::string Position(const std::filesystem::path& file, const std::vector<Sample>& samples,
                     const std::vector<LogRow>& rows, const PlotOptions& options, bool fixes) {
  static constexpr const char* kOfPad[] = {"x of the pad (m)", "y of the pad (m)",
                                           "height above the pad (m)"};
  static constexpr const char* kOfGround[] = {"north (m)", "east (m)", "height (m)"};
  std::string text =
      BeginFigure(file, 1200, 1100) +
      BeginPanels(kThreePanels,
                  (options.pad_size_m ? "Position in the frame of the pad: " : "Position: ") + options.title);
  text += "set xrange " + TimeRange(rows) + '\n';
  for (int axis = 0; axis < 3; ++axis) {
    Span span;
    for (const Sample& s : samples)
      span.Add(s.truth[axis]), span.Add(s.fix[axis]), span.Add(s.estimate[axis]);
    text += PhaseLines(rows, axis == 0);
    if (axis == 2) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += AxisName((options.pad_size_m ? kOfPad : kOfGround)[axis]) + (axis == 0 ? kKey : "unset key\n");
    text += fmt::format("set yrange {}\nplot $flight using 8:{} with {} title 'autopilot', ", span.Range(0.5),
                        9 + axis, kEstimateStyle);
    if (fixes) text += fmt::format("'' using 1:{} with {} title 'vision fix', ", 5 + axis, kSeenStyle);
    text += fmt::format("'' using 1:{} with {} title 'truth'\n", 2 + axis, kTruthStyle);
  }
  return text + EndFigure();
}

std::string Error(const std::filesystem::path& file, const std::vector<Sample>& samples,
                  const std::vector<LogRow>& rows, const std::string& title) {
  Span position, yaw, distance;
  distance.Add(0);
  for (const Sample& s : samples) {
    for (const double each : s.error) position.Add(each);
    yaw.Add(s.yaw_error_deg);
    distance.Add(s.distance_m);
  }
  std::string text =
      BeginFigure(file, 1200, 1100) + BeginPanels(kThreePanels, "Error of the vision fix: " + title);
  text += "set xrange " + TimeRange(rows) + "\nset xzeroaxis lc rgb '#888888'\n";
  text += PhaseLines(rows, true) + AxisName("fix less truth (m)") + kKey;
  text += fmt::format(
      "set yrange {}\n"
      "plot $flight using 1:14 with points pt 7 ps 0.45 lc rgb '#009E73' title 'z (down)', "
      "'' using 1:12 with points pt 7 ps 0.45 lc rgb '#D55E00' title 'x', "
      "'' using 1:13 with points pt 7 ps 0.45 lc rgb '#0072B2' title 'y'\n",
      position.Range(0.02));
  text += PhaseLines(rows, false) + AxisName("yaw, fix less truth (°)") + "unset key\n";
  text += fmt::format(
      "set yrange {}\n"
      "plot $flight using 1:15 with points pt 7 ps 0.45 lc rgb '#882255'\n",
      yaw.Range(0.5));
  text += PhaseLines(rows, false) + AxisName("horizontal distance (m)");
  text += fmt::format(
      "set format x '%g'\nset xlabel 'time (s)'\nset yrange {}\n"
      "plot $flight using 1:16 with {}\n",
      distance.Range(0.5), kTruthStyle);
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
    s.plots += "$pad using 1:2:(0) with lines lw 3 lc rgb '#009E73' title 'pad', ";
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

std::string Trajectory(const std::filesystem::path& file, const std::vector<Sample>& samples,
                       const std::vector<LogRow>& rows, const PlotOptions& options) {
  Span x, y, height;
  height.Add(0);
  for (const Sample& s : samples) x.Add(s.truth.x()), y.Add(s.truth.y()), height.Add(s.truth.z());
  const Surroundings about = SurroundingsOf(rows, options, x, y, height);
  // Right, forward, up: so that turning right looks like it.
  std::string text = BeginFigure(file, 1200, 1000) + about.data;
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
         "$start using 1:2:3 with points pt 7 ps 2 lc rgb '#0072B2' title 'start', "
         "$end using 1:2:3 with points pt 9 ps 2 lc rgb '#D55E00' title 'end'\n" +
         EndFigure();
}

// Columns: time, then of roll, pitch and heading the truth, what the camera gave, its error and twice the
// deviation that it states; in degrees, headings from the camera's first.
std::string AttitudeData(const std::vector<LogRow>& rows) {
  std::string text = "$attitude << END_OF_ATTITUDE\n";
  double turned = 0, last_yaw = YawOf(rows.front().exposure.X_NB.R), zero = kNone;
  for (const LogRow& row : rows) {
    const TaitBryan truth = TaitBryanFromRotation(row.exposure.X_NB.R.toRotationMatrix());
    turned += WrapAngle(truth.yaw - last_yaw);
    last_yaw = truth.yaw;
    const auto& fix = row.decision.attitude;
    const bool headed = fix && fix->turned;
    if (headed && std::isnan(zero)) zero = turned - *fix->turned;
    text += fmt::format("{:.4f}", row.exposure.t_s);
    const auto add = [&](double is, double seen, double sigma) {
      text += fmt::format(" {:.6g} {:.6g} {:.6g} {:.6g}", Degrees(is), Degrees(seen), Degrees(seen - is),
                          Degrees(2 * sigma));
    };
    add(truth.roll, fix ? fix->roll : kNone, fix ? fix->roll_sigma : kNone);
    add(truth.pitch, fix ? fix->pitch : kNone, fix ? fix->pitch_sigma : kNone);
    add(turned - zero, headed ? *fix->turned : kNone, headed ? fix->turned_sigma : kNone);
    text += '\n';
  }
  return text + "END_OF_ATTITUDE\n";
}

std::string Attitude(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                     const std::string& title) {
  static constexpr const char* kAngles[] = {"roll", "pitch", "heading"};
  std::string text = BeginFigure(file, 1600, 1000) +
                     BeginPanels("layout 3,2 margins 0.06,0.98,0.07,0.90 spacing 0.07,0.05",
                                 "Attitude by the skyline, heading by the surroundings: " + title) +
                     "set xrange " + TimeRange(rows) + '\n';
  const bool headed = std::any_of(rows.begin(), rows.end(), [](const LogRow& row) {
    return row.decision.attitude && row.decision.attitude->turned;
  });
  for (int i = 0; i < 3; ++i) {
    const int truth = 2 + 4 * i;
    const char* range = i == 2 && !headed ? "set yrange [-1:1]\n" : "set autoscale y\n";
    if (i == 2) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text +=
        PhaseLines(rows, i == 0) + range + "unset xzeroaxis\n" +
        fmt::format("set ylabel '{} (°)' offset 1,0\n", kAngles[i]) +
        (i == 0 ? "set key at screen 0.49, 0.955 right top horizontal noautotitle samplen 2\n"
                : "unset key\n") +
        fmt::format("plot $attitude using 1:{} with {} title 'camera', '' using 1:{} with {} title 'truth'\n",
                    truth + 1, kSeenStyle, truth, kTruthStyle);
    text +=
        PhaseLines(rows, false) + "set xzeroaxis lc rgb '#888888'\n" +
        fmt::format("set ylabel '{}, camera less truth (°)' offset 1,0\n", kAngles[i]) +
        (i == 0 ? "set key at screen 0.98, 0.955 right top horizontal noautotitle samplen 2\n"
                : "unset key\n") +
        fmt::format(
            "plot $attitude using 1:{0} with lines lw 1 lc rgb '#999999' title '2 deviations, as stated', "
            "'' using 1:(-${0}) with lines lw 1 lc rgb '#999999', "
            "'' using 1:{1} with points pt 7 ps 0.35 lc rgb '#D55E00' title 'error'\n",
            truth + 3, truth + 2);
  }
  return text + EndFigure();
}

}  // namespace

std::vector<std::string> PlotNames() {
  return {"position.png", "error.png",     "trajectory.png", "attitude.png",
          "follow.png",   "encounter.png", "flown.png"};
}

void DrawPlots(const std::filesystem::path& folder, const std::vector<LogRow>& rows,
               const PlotOptions& options) {
  if (rows.empty()) return;
  const std::vector<Sample> samples = SamplesOf(rows, options);
  const auto any = [&rows](auto&& has) { return std::any_of(rows.begin(), rows.end(), has); };
  const bool attitude = any([](const LogRow& row) { return row.decision.attitude.has_value(); });
  const bool fix = any([](const LogRow& row) { return row.decision.fix.has_value(); });
  const std::string& title = options.title;
  std::vector<std::filesystem::path> files;
  const auto file = [&](const char* name) { return files.emplace_back(folder / name); };
  try {
    PipedProgram gnuplot({"gnuplot", "-d"});
    gnuplot.Write(Data(samples, rows));
    gnuplot.Write(Position(file("position.png"), samples, rows, options, fix));
    gnuplot.Write(Trajectory(file("trajectory.png"), samples, rows, options));
    if (fix || (options.pad_size_m && !attitude))
      gnuplot.Write(Error(file("error.png"), samples, rows, title));
    if (attitude) gnuplot.Write(AttitudeData(rows) + Attitude(file("attitude.png"), rows, title));
    if (FollowsBalloon(rows)) gnuplot.Write(FollowPlot(file("follow.png"), rows, title));
    if (MeetsOthers(rows)) gnuplot.Write(EncounterPlot(file("encounter.png"), rows, title));
    gnuplot.Close();
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(fmt::format("cannot draw {}: {}", folder.string(), e.what()));
  }
  for (const std::filesystem::path& each : files) {
    RequireWholePng(each);
    Complete(each);
  }
}

}  // namespace kestrel
