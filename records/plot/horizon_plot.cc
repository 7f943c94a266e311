// SPDX-License-Identifier: Apache-2.0
#include "records/plot/horizon_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/horizon_observer.h"
#include "records/plot/plot_parts.h"

namespace kestrel::records {
namespace {

constexpr const char* kFailedColour = "#fbe3e3";

struct Angles {
  double roll = kNone, pitch = kNone, heading = kNone;  // rad
  double of(int i) const { return i == 0 ? roll : i == 1 ? pitch : heading; }
};

// Of one row: roll, pitch and heading, headings from the first of each.
struct Line {
  double t_s = 0, now_s = 0;
  Angles truth, seen, sigma, baseline, own;  // own: the autopilot's, without what it is aided by
  double error(int i) const { return seen.of(i) - truth.of(i); }
};

const mission::HorizonReport* HorizonOf(const LogRow& row) {
  return mission::ReportOf<mission::HorizonReport>(row.decision);
}

// An angle that goes on through whole turns.
class Unwrapped {
 public:
  double Add(double yaw) {
    turned_ = std::isnan(last_) ? 0 : turned_ + WrapAngle(yaw - last_);
    last_ = yaw;
    return turned_;
  }

 private:
  double turned_ = 0, last_ = kNone;
};

std::vector<Line> LinesOf(const std::vector<LogRow>& rows) {
  std::vector<Line> lines;
  Unwrapped true_yaw, own_yaw;
  double zero = kNone, baseline_zero = kNone, own_zero = kNone;
  for (const LogRow& row : rows) {
    Line line{row.exposure.t_s, row.now.t_s, {}, {}, {}, {}, {}};
    const TaitBryan truth = TaitBryanFromRotation(row.exposure.X_NB.R.toRotationMatrix());
    const double turned = true_yaw.Add(truth.yaw);
    const mission::HorizonReport* report = HorizonOf(row);
    const mission::AttitudeFix* fix = report && report->attitude ? &*report->attitude : nullptr;
    if (fix) {
      if (fix->turned && std::isnan(zero)) zero = turned - *fix->turned;
      line.seen = {fix->roll, fix->pitch, fix->turned.value_or(kNone)};
      line.sigma = {fix->roll_sigma, fix->pitch_sigma, fix->turned ? fix->turned_sigma : kNone};
    }
    line.truth = {truth.roll, truth.pitch, turned - zero};
    if (const auto* baseline = report && report->baseline ? &*report->baseline : nullptr) {
      const double heading = baseline->turned.value_or(kNone);
      if (std::isnan(baseline_zero)) baseline_zero = turned - heading;
      line.baseline = {baseline->roll, baseline->pitch, heading + baseline_zero - zero};
    }
    if (const auto& R_NB = row.estimate.R_NB_inertial; R_NB && row.heard) {
      const TaitBryan own = TaitBryanFromRotation(R_NB->toRotationMatrix());
      const double heading = own_yaw.Add(own.yaw);
      if (std::isnan(own_zero)) own_zero = turned - zero - heading;
      line.own = {own.roll, own.pitch, heading + own_zero};
    }
    lines.push_back(line);
  }
  return lines;
}

// Columns: time of the exposure, of the row; then of each angle the truth, what the camera gave, its error, twice
// the sigma that it states, the reference method, the autopilot's own; in degrees.
constexpr int kColumns = 6;
std::string Data(const std::vector<Line>& lines) {
  std::string text = "$attitude << END_OF_ATTITUDE\n";
  for (const Line& line : lines) {
    text += fmt::format("{:.4f} {:.4f}", line.t_s, line.now_s);
    for (int i = 0; i < 3; ++i)
      for (const double each : {line.truth.of(i), line.seen.of(i), line.error(i), 2 * line.sigma.of(i),
                                line.baseline.of(i), line.own.of(i)})
        text += fmt::format(" {:.6g}", Degrees(each));
    text += '\n';
  }
  return text + "END_OF_ATTITUDE\n";
}

// An attitude that has failed may be anywhere: the others are to stay legible.
Span SpanOf(const std::vector<Line>& lines, int i) {
  Span span, own;
  for (const Line& line : lines) {
    for (const double each : {line.truth.of(i), line.seen.of(i), line.baseline.of(i)})
      span.Add(Degrees(each));
    own.Add(Degrees(line.own.of(i)));
  }
  if (!(span.low <= span.high) || !(own.low <= own.high)) return span;
  const double reach = 1.5 * std::max(span.size(), 2.0);
  span.Add(std::max(own.low, span.low - reach));
  span.Add(std::min(own.high, span.high + reach));
  return span;
}

}  // namespace

bool MeasuresAttitude(const std::vector<LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const LogRow& row) {
    const mission::HorizonReport* report = HorizonOf(row);
    return report && report->attitude;
  });
}

std::string HorizonPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                        const mission::FigureText& figure) {
  struct Angle {
    const char* name;
    std::vector<std::string> metrics;  // of its error
  };
  const Angle angles[] = {{"roll", {"roll_rmse_deg", "failure_attitude_rms_deg"}},
                          {"pitch", {"pitch_rmse_deg", "failure_attitude_rms_deg"}},
                          {"heading", {"yaw_rmse_deg", "failure_heading_worst_deg"}}};
  const std::vector<Line> lines = LinesOf(rows);
  const auto any = [&lines](auto&& angle) {
    return std::any_of(lines.begin(), lines.end(), [&](const Line& l) { return !std::isnan(angle(l)); });
  };
  const bool compared = any([](const Line&l) { return l.baseline.roll; }),
             own = any([](const Line&l) { return l.own.roll; });
  const bool failed =
      std::any_of(rows.begin(), rows.end(), [](const LogRow& row) { return row.now.attitude_failed; });
  std::string text =
      Data(lines) + BeginFigure(file, 1600, 1000) +
      BeginPanels("layout 3,2 margins 0.06,0.98,0.07,0.88 spacing 0.07,0.05",
                  "Attitude by the skyline, heading by the surroundings: " + figure.title) +
      "set xrange " + TimeRange(rows) + '\n' +
      Shades(rows, [](const LogRow& row) { return row.now.attitude_failed ? kFailedColour : "#ffffff"; });
  const auto key = [](const char* right) {
    return fmt::format("set key at screen {}, 0.955 right top horizontal noautotitle samplen 2\n", right);
  };
  for (int i = 0; i < 3; ++i) {
    const int truth = 3 + kColumns * i;
    if (i == 2) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += PhaseLines(rows, i == 0) + "unset xzeroaxis\n" +
            fmt::format("set yrange {}\nset ylabel '{} (°)' offset 1,0\n", SpanOf(lines, i).Range(2),
                        angles[i].name) +
            (i == 0 ? key("0.49") : "unset key\n") + "plot ";
    if (own)
      text += fmt::format("$attitude using 2:{} with {} title 'own of the autopilot', ", truth + 5,
                          kEstimateStyle);
    if (compared)
      text += fmt::format(
          "$attitude using 1:{} with points pt 7 ps 0.4 lc rgb '#CC79A7' title 'reference method', ",
          truth + 4);
    text += fmt::format("$attitude using 1:{} with {} title 'camera', '' using 1:{} with {} title 'truth'",
                        truth + 1, kSeenStyle, truth, kTruthStyle);
    if (failed)
      text += fmt::format(", keyentry with boxes fs solid noborder fc rgb '{}' title 'own has failed'",
                          kFailedColour);
    Span errors;
    for (const Line& line : lines)
      for (const double each : {line.error(i), 2 * line.sigma.of(i), -2 * line.sigma.of(i)})
        errors.Add(Degrees(each));
    const std::string limits = LimitLines(figure, angles[i].metrics, errors, true);
    text += '\n' + PhaseLines(rows, false) + limits + "set xzeroaxis lc rgb '#888888'\n" +
            fmt::format("set yrange {}\nset ylabel '{}, camera less truth (°)' offset 1,0\n",
                        errors.Range(0.2), angles[i].name) +
            (i == 0 ? key("0.98") : "unset key\n") +
            fmt::format(
                "plot $attitude using 1:{0} with lines lw 1 lc rgb '#999999' title '2 sigma, as stated', "
                "'' using 1:(-${0}) with lines lw 1 lc rgb '#999999', "
                "'' using 1:{1} with points pt 7 ps 0.35 lc rgb '#E69F00' title 'error'\n",
                truth + 3, truth + 2);
  }
  return text + EndFigure();
}

}  // namespace kestrel::records
