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

// Columns: time, then of roll, pitch and heading the truth, what the camera gave, its error and twice the
// sigma that it states; then the three by the reference method, where there is one; in degrees, headings from
// the first of each.
std::string Data(const std::vector<LogRow>& rows) {
  std::string text = "$attitude << END_OF_ATTITUDE\n";
  double turned = 0, last_yaw = YawOf(rows.front().exposure.X_NB.R), zero = kNone, baseline_zero = kNone;
  for (const LogRow& row : rows) {
    const TaitBryan truth = TaitBryanFromRotation(row.exposure.X_NB.R.toRotationMatrix());
    turned += WrapAngle(truth.yaw - last_yaw);
    last_yaw = truth.yaw;
    const auto* report = mission::ReportOf<mission::HorizonReport>(row.decision);
    const mission::AttitudeFix* fix = report && report->attitude ? &*report->attitude : nullptr;
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
    const mission::AttitudeFix* baseline = report && report->baseline ? &*report->baseline : nullptr;
    const bool baseline_headed = baseline && baseline->turned;
    if (baseline_headed && std::isnan(baseline_zero)) baseline_zero = turned - *baseline->turned;
    text += fmt::format(" {:.6g} {:.6g} {:.6g}\n", baseline ? Degrees(baseline->roll) : kNone,
                        baseline ? Degrees(baseline->pitch) : kNone,
                        baseline_headed ? Degrees(*baseline->turned + baseline_zero - zero) : kNone);
  }
  return text + "END_OF_ATTITUDE\n";
}

}  // namespace

bool MeasuresAttitude(const std::vector<LogRow>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const LogRow& row) {
    const auto* report = mission::ReportOf<mission::HorizonReport>(row.decision);
    return report && report->attitude;
  });
}

std::string HorizonPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                        const std::string& title) {
  static constexpr const char* kAngles[] = {"roll", "pitch", "heading"};
  std::string text = Data(rows) + BeginFigure(file, 1600, 1000) +
                     BeginPanels("layout 3,2 margins 0.06,0.98,0.07,0.90 spacing 0.07,0.05",
                                 "Attitude by the skyline, heading by the surroundings: " + title) +
                     "set xrange " + TimeRange(rows) + '\n';
  const bool compared = std::any_of(rows.begin(), rows.end(), [](const LogRow& row) {
    const auto* report = mission::ReportOf<mission::HorizonReport>(row.decision);
    return report && report->baseline;
  });
  const bool headed = std::any_of(rows.begin(), rows.end(), [](const LogRow& row) {
    const auto* report = mission::ReportOf<mission::HorizonReport>(row.decision);
    return report && report->attitude && report->attitude->turned;
  });
  for (int i = 0; i < 3; ++i) {
    const int truth = 2 + 4 * i;
    const char* range = i == 2 && !headed ? "set yrange [-1:1]\n" : "set autoscale y\n";
    if (i == 2) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += PhaseLines(rows, i == 0) + range + "unset xzeroaxis\n" +
            fmt::format("set ylabel '{} (°)' offset 1,0\n", kAngles[i]) +
            (i == 0 ? "set key at screen 0.49, 0.955 right top horizontal noautotitle samplen 2\n"
                    : "unset key\n") +
            "plot " +
            (compared ? fmt::format(
                            "$attitude using 1:{} with points pt 7 ps 0.4 lc rgb '#CC79A7' title 'reference "
                            "method', ",
                            14 + i)
                      : "") +
            fmt::format("$attitude using 1:{} with {} title 'camera', '' using 1:{} with {} title 'truth'\n",
                        truth + 1, kSeenStyle, truth, kTruthStyle);
    text += PhaseLines(rows, false) + "set xzeroaxis lc rgb '#888888'\n" +
            fmt::format("set ylabel '{}, camera less truth (°)' offset 1,0\n", kAngles[i]) +
            (i == 0 ? "set key at screen 0.98, 0.955 right top horizontal noautotitle samplen 2\n"
                    : "unset key\n") +
            fmt::format(
                "plot $attitude using 1:{0} with lines lw 1 lc rgb '#999999' title '2 sigma, as stated', "
                "'' using 1:(-${0}) with lines lw 1 lc rgb '#999999', "
                "'' using 1:{1} with points pt 7 ps 0.35 lc rgb '#D55E00' title 'error'\n",
                truth + 3, truth + 2);
  }
  return text + EndFigure();
}

}  // namespace kestrel::records
