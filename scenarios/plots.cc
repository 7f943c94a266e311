// SPDX-License-Identifier: Apache-2.0
#include "scenarios/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/tait_bryan.h"
#include "scenarios/files.h"
#include "scenarios/gnuplot.h"
#include "scenarios/piped_program.h"

namespace kestrel {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// One frame as it is drawn; without a fix its numbers are NaN, which gnuplot leaves out.
struct Sample {
  double t_s = 0;
  Eigen::Vector3d truth, fix, estimate;  // x and y of the pad, height above it, m
  Eigen::Vector3d error;                 // of the fix: x, y, z of the pad, m
  double yaw_error_deg = kNone;
  double distance_m = 0;
};

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  void Add(double value) {
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  }
  // With a margin, and wide enough that noise does not look like motion.
  std::string Range(double least) const {
    if (!(low <= high)) return fmt::format("[{}:{}]", -least / 2, least / 2);
    const double grow = std::max(0.06 * (high - low), (least - (high - low)) / 2);
    return fmt::format("[{:.6g}:{:.6g}]", low - grow, high + grow);
  }
};

// A round distance between ticks for a handful of them.
double TickStep(const Span& span, double least) {
  const double wanted = std::max(span.high - span.low, least) / 5;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  for (const double each : {1, 2, 5}) {
    if (each * power >= wanted) return each * power;
  }
  return 10 * power;
}

Eigen::Vector3d HeightUp(const Eigen::Vector3d& p_T) { return {p_T.x(), p_T.y(), -p_T.z()}; }

std::vector<Sample> SamplesOf(const std::vector<LogRow>& rows) {
  std::vector<Sample> samples;
  for (const LogRow& row : rows) {
    const Pose X_TN = row.exposure.X_NT.Inverse();
    const Pose X_TB = X_TN * row.exposure.X_NB;
    Sample s{row.exposure.t_s,
             HeightUp(X_TB.p),
             Eigen::Vector3d::Constant(kNone),
             HeightUp(row.now.X_NT.Inverse() * row.estimate.p_NB),
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

// A line where each phase of the flight begins, with its name above the topmost panel where there is room.
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

// As a label, so that those of all panels stand in one line.
std::string Vertical(const std::string& name) {
  return fmt::format("set label '{}' at graph -0.07, 0.5 center rotate\n", name);
}

std::string Begin(const std::filesystem::path& file, int width_px, int height_px) {
  return fmt::format(
      "reset\nset terminal pngcairo size {},{} font 'DejaVu Sans,12' background rgb 'white'\n"
      "set output {}\nset encoding utf8\n"
      "set border 3 lc rgb '#444444'\nset tics nomirror out scale 0.6\n"
      "set grid lc rgb '#dddddd' lt 1 lw 1\n",
      width_px, height_px, GnuplotQuoted(PartOf(file).string()));
}

constexpr const char* kKey =
    "set key at screen 0.97, 0.965 right top horizontal noautotitle samplen 2 width 2\n";
constexpr const char* kTruth = "lines lw 1.6 lc rgb '#222222'";
constexpr const char* kFix = "points pt 7 ps 0.6 lc rgb '#E69F00'";
constexpr const char* kEstimate = "lines lw 1.8 dt (8,4) lc rgb '#0072B2'";

std::string Panels(const std::string& title) {
  return fmt::format(
      "set multiplot layout 3,1 title {} noenhanced font ',14' margins 0.09,0.97,0.07,0.90 spacing 0,0.035\n"
      "set format x ''\n",
      GnuplotQuoted(title));
}

std::string Position(const std::filesystem::path& file, const std::vector<Sample>& samples,
                     const std::vector<LogRow>& rows, const std::string& title, const std::string& times) {
  static constexpr const char* kAxes[] = {"x of the pad (m)", "y of the pad (m)", "height above the pad (m)"};
  std::string text = Begin(file, 1200, 1100) + Panels("Position in the frame of the pad: " + title);
  text += "set xrange " + times + '\n';
  for (int axis = 0; axis < 3; ++axis) {
    Span span;
    for (const Sample& s : samples)
      span.Add(s.truth[axis]), span.Add(s.fix[axis]), span.Add(s.estimate[axis]);
    text += PhaseLines(rows, axis == 0);
    if (axis == 2) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += Vertical(kAxes[axis]) + (axis == 0 ? kKey : "unset key\n");
    text += fmt::format(
        "set yrange {}\n"
        "plot $flight using 8:{} with {} title 'autopilot', '' using 1:{} with {} title 'vision fix', "
        "'' using 1:{} with {} title 'truth'\n",
        span.Range(0.5), 9 + axis, kEstimate, 5 + axis, kFix, 2 + axis, kTruth);
  }
  return text + "unset multiplot\nunset output\n";
}

std::string Error(const std::filesystem::path& file, const std::vector<Sample>& samples,
                  const std::vector<LogRow>& rows, const std::string& title, const std::string& times) {
  Span position, yaw, distance;
  distance.Add(0);
  for (const Sample& s : samples) {
    for (const double each : s.error) position.Add(each);
    yaw.Add(s.yaw_error_deg);
    distance.Add(s.distance_m);
  }
  std::string text = Begin(file, 1200, 1100) + Panels("Error of the vision fix: " + title);
  text += "set xrange " + times + "\nset xzeroaxis lc rgb '#888888'\n";
  text += PhaseLines(rows, true) + Vertical("fix less truth (m)") + kKey;
  text += fmt::format(
      "set yrange {}\n"
      "plot $flight using 1:14 with points pt 7 ps 0.45 lc rgb '#009E73' title 'z (down)', "
      "'' using 1:12 with points pt 7 ps 0.45 lc rgb '#D55E00' title 'x', "
      "'' using 1:13 with points pt 7 ps 0.45 lc rgb '#0072B2' title 'y'\n",
      position.Range(0.02));
  text += PhaseLines(rows, false) + Vertical("yaw, fix less truth (°)") + "unset key\n";
  text += fmt::format(
      "set yrange {}\n"
      "plot $flight using 1:15 with points pt 7 ps 0.45 lc rgb '#882255'\n",
      yaw.Range(0.5));
  text += PhaseLines(rows, false) + Vertical("horizontal distance (m)");
  text += fmt::format(
      "set format x '%g'\nset xlabel 'time (s)'\nset yrange {}\n"
      "plot $flight using 1:16 with {}\n",
      distance.Range(0.5), kTruth);
  return text + "unset multiplot\nunset output\n";
}

std::string Trajectory(const std::filesystem::path& file, const std::vector<Sample>& samples,
                       const std::string& title, const Eigen::Vector2d& pad_size_m) {
  const Eigen::Vector2d half = pad_size_m / 2;
  Span x, y, height;
  x.Add(-half.x()), x.Add(half.x()), y.Add(-half.y()), y.Add(half.y()), height.Add(0);
  for (const Sample& s : samples) x.Add(s.truth.x()), y.Add(s.truth.y()), height.Add(s.truth.z());
  // Right, forward, up: so that turning right looks like it.
  std::string text = Begin(file, 1200, 1000) + "$pad << END_OF_PAD\n";
  for (const auto& [sx, sy] : {std::pair{1, 1}, {1, -1}, {-1, -1}, {-1, 1}, {1, 1}}) {
    text += fmt::format("{} {}\n", sy * half.y(), sx * half.x());
  }
  const Eigen::Vector3d &start = samples.front().truth, &end = samples.back().truth;
  text += fmt::format(
      "END_OF_PAD\n$start << END_OF_START\n{} {} {}\nEND_OF_START\n$end << END_OF_END\n{} {} "
      "{}\nEND_OF_END\n",
      start.y(), start.x(), start.z(), end.y(), end.x(), end.z());
  text += fmt::format(
      "set label 1 {} at screen 0.5, 0.965 center noenhanced font ',14'\nset border 895 lc rgb '#bbbbbb'\n"
      "set tics textcolor rgb '#333333'\n"
      "set xyplane at 0\nset view 62,35,1.12,1.0\nset view equal xy\nset grid xtics ytics ztics vertical\n"
      "set xrange {}\nset yrange {}\nset zrange [0:{:.6g}]\nset xtics {}\nset ytics {}\nset ztics {}\n"
      "set xlabel 'y of the pad, right (m)' rotate parallel offset 0,-1\n"
      "set ylabel 'x of the pad, forward (m)' rotate parallel offset 0,-1\n"
      "set zlabel 'height (m)' rotate parallel\n"
      "set key at screen 0.03, 0.93 left top vertical Left reverse noautotitle\n",
      GnuplotQuoted("True trajectory: " + title), y.Range(1.0), x.Range(1.0),
      1.06 * std::max(height.high, 0.5), TickStep(y, 1.0), TickStep(x, 1.0), TickStep(height, 0.5));
  return text +
         "splot $flight using 3:2:(0) with lines lw 1.5 lc rgb '#bbbbbb' title 'track on the ground', "
         "$pad using 1:2:(0) with lines lw 3 lc rgb '#009E73' title 'pad', "
         "$flight using 3:2:4 with lines lw 2.5 lc rgb '#222222' title 'aircraft', "
         "$start using 1:2:3 with points pt 7 ps 2 lc rgb '#0072B2' title 'start', "
         "$end using 1:2:3 with points pt 9 ps 2 lc rgb '#D55E00' title 'end'\nunset output\n";
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
                     const std::string& title, const std::string& times) {
  static constexpr const char* kAngles[] = {"roll", "pitch", "heading"};
  std::string text =
      Begin(file, 1600, 1000) +
      fmt::format(
          "set multiplot layout 3,2 title {} noenhanced font ',14' margins 0.06,0.98,0.07,0.90 "
          "spacing 0.07,0.05\nset format x ''\nset xrange {}\n",
          GnuplotQuoted("Attitude by the skyline, heading by the surroundings: " + title), times);
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
                    truth + 1, kFix, truth, kTruth);
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
  return text + "unset multiplot\nunset output\n";
}

}  // namespace

std::vector<std::string> PlotNames() {
  return {"position.png", "error.png", "trajectory.png", "attitude.png"};
}

void DrawPlots(const std::filesystem::path& folder, const std::vector<LogRow>& rows,
               const PlotOptions& options) {
  if (rows.empty()) return;
  const std::vector<Sample> samples = SamplesOf(rows);
  const double first_s = samples.front().t_s;
  const std::string times =
      fmt::format("[{:.4f}:{:.4f}]", first_s, std::max(rows.back().now.t_s, first_s + 0.1));
  const bool attitude =
      std::any_of(rows.begin(), rows.end(), [](const LogRow& row) { return row.decision.attitude; });
  const bool fix = std::any_of(rows.begin(), rows.end(), [](const LogRow& row) { return row.decision.fix; });
  std::vector<std::string> names = {"position.png", "trajectory.png"};
  if (fix || !attitude) names.push_back("error.png");
  if (attitude) names.push_back("attitude.png");
  try {
    PipedProgram gnuplot({"gnuplot", "-d"});
    gnuplot.Write(Data(samples, rows));
    gnuplot.Write(Position(folder / "position.png", samples, rows, options.title, times));
    gnuplot.Write(Trajectory(folder / "trajectory.png", samples, options.title, options.pad_size_m));
    if (fix || !attitude) gnuplot.Write(Error(folder / "error.png", samples, rows, options.title, times));
    if (attitude) {
      gnuplot.Write(AttitudeData(rows));
      gnuplot.Write(Attitude(folder / "attitude.png", rows, options.title, times));
    }
    gnuplot.Close();
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(fmt::format("cannot draw {}: {}", folder.string(), e.what()));
  }
  for (const std::string& name : names) {
    RequireWholePng(folder / name);
    Complete(folder / name);
  }
}

}  // namespace kestrel
