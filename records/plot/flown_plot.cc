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
constexpr int kSeen = 2, kHeight = 5, kAsked = 6, kSent = 9, kRoll = 12;
struct Row {
  Eigen::Vector3d seen = Eigen::Vector3d::Constant(kNone), asked, sent;
  double height_m = kNone, roll_deg = kNone, pitch_deg = kNone;

  explicit Row(const LogRow& row) : asked(VelocityOf(row.decision.setpoint)), sent(VelocityOf(row.sent)) {
    if (const auto& fix = row.decision.fix) seen = {fix->p_TB.x(), fix->p_TB.y(), -fix->p_TB.z()};
    if (!row.heard) return;
    const TaitBryan angles = TaitBryanFromRotation(row.estimate.R_NB.toRotationMatrix());
    height_m = -row.estimate.p_NB.z();
    roll_deg = Degrees(angles.roll), pitch_deg = Degrees(angles.pitch);
  }
};

std::string Data(const std::vector<LogRow>& rows) {
  std::string text = "$flown << END_OF_FLIGHT\n";
  for (const LogRow& each : rows) {
    const Row row(each);
    text += fmt::format("{:.4f} {:.6g} {:.6g} {:.6g} {:.6g}", each.now.t_s, row.seen.x(), row.seen.y(),
                        row.seen.z(), row.height_m);
    for (const Eigen::Vector3d& v : {row.asked, row.sent})
      text += fmt::format(" {:.6g} {:.6g} {:.6g}", v.x(), v.y(), v.z());
    text += fmt::format(" {:.6g} {:.6g}\n", row.roll_deg, row.pitch_deg);
  }
  return text + "END_OF_FLIGHT\n";
}

constexpr const char* kAskedStyle = "lines lw 1.2 dt (3,3) lc rgb '#009E73'";
constexpr const char* kHeldColour = "#fbe3e3";
std::string_view ShadeOf(const LogRow& row) {
  return row.reaction == control::NameOf(control::Reaction::kFly) ? "#ffffff" : kHeldColour;
}

}  // namespace

void DrawFlownPlot(const std::filesystem::path& file, const std::vector<LogRow>& rows,
                   const std::string& title) {
  if (rows.empty()) return;
  std::string text = Data(rows) + BeginFigure(file, 1200, 1700) +
                     BeginPanels("layout 8,1 margins 0.09,0.97,0.045,0.93 spacing 0,0.02", title) +
                     "set xrange " + TimeRange(rows) + "\n" + Shades(rows, ShadeOf) +
                     "set key at screen 0.97, 0.972 right top horizontal noautotitle samplen 2\n";
  int panels = 0;
  const auto panel = [&](const std::string& name, double least, auto&& values, const std::string& plot) {
    Span span;
    for (const LogRow& row : rows)
      for (const double value : values(Row(row))) span.Add(value);
    if (panels == 1) text += "unset key\n";
    text += PhaseLines(rows, panels == 0) + AxisName(name);
    if (++panels == 8) text += "set format x '%g'\nset xlabel 'time (s)'\n";
    text += fmt::format("set yrange {}\nplot {}\n", span.Range(least), plot);
  };
  using Values = std::vector<double>;
  const auto using_ = [](int column, const char* style, const char* name) {
    return fmt::format("$flown using 1:{} with {} title '{}'", column, style, name);
  };
  // The key is that of all panels.
  const std::string keys = fmt::format(
      ", keyentry with {} title 'autopilot', keyentry with {} title 'sent', keyentry with {} title 'asked "
      "for', "
      "keyentry with boxes fs solid noborder fc rgb '{}' title 'the safety layer stood in'",
      kEstimateStyle, kSetpointStyle, kAskedStyle, kHeldColour);
  panel(
      "x, forward (m)", 0.5, [](const Row& r) { return Values{r.seen.x()}; },
      using_(kSeen, kSeenStyle, "vision fix") + keys);
  panel(
      "y, right (m)", 0.5, [](const Row& r) { return Values{r.seen.y()}; },
      using_(kSeen + 1, kSeenStyle, ""));
  panel(
      "height (m)", 0.5,
      [](const Row& r) {
        return Values{r.seen.z(), r.height_m};
      },
      using_(kHeight, kEstimateStyle, "") + ", " + using_(kSeen + 2, kSeenStyle, ""));
  constexpr const char* kNames[] = {"forward (m/s)", "right (m/s)", "down (m/s)"};
  for (int i = 0; i < 3; ++i)
    panel(
        kNames[i], 0.2,
        [i](const Row& r) {
          return Values{r.asked[i], r.sent[i], 0};
        },
        using_(kSent + i, kSetpointStyle, "") + ", " + using_(kAsked + i, kAskedStyle, ""));
  panel(
      "roll (°)", 2, [](const Row& r) { return Values{r.roll_deg}; }, using_(kRoll, kEstimateStyle, ""));
  panel(
      "pitch (°)", 2, [](const Row& r) { return Values{r.pitch_deg}; },
      using_(kRoll + 1, kEstimateStyle, ""));
  RunGnuplot(file, text + EndFigure());
}

}  // namespace kestrel::records
