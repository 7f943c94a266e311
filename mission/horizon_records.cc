// SPDX-License-Identifier: Apache-2.0
#include "mission/horizon_records.h"

#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"

namespace kestrel::mission {
namespace {

constexpr double kOutlier_deg = 5;

// Of the attitude that images gave, one source of it.
void AddAttitude(const std::vector<LogRow>& rows, std::optional<AttitudeFix> HorizonReport::*source,
                 const std::string& prefix, std::map<std::string, double>& m) {
  MeanSquare roll, pitch, yaw, early, late;
  int fixes = 0, outliers = 0, stated = 0, within = 0;
  double truth_turned = 0, last_yaw = YawOf(rows.front().exposure.X_NB.R);
  std::optional<double> zero;  // of the truth, where the heading's own is
  const double middle_s = 0.5 * (rows.front().exposure.t_s + rows.back().exposure.t_s);
  for (const LogRow& row : rows) {
    const TaitBryan truth = TaitBryanFromRotation(row.exposure.X_NB.R.toRotationMatrix());
    truth_turned += WrapAngle(truth.yaw - last_yaw);
    last_yaw = truth.yaw;
    const auto* report = ReportOf<HorizonReport>(row.decision);
    if (!report || !(report->*source)) continue;
    const AttitudeFix* fix = &*(report->*source);
    ++fixes;
    const double e_roll = WrapAngle(fix->roll - truth.roll), e_pitch = fix->pitch - truth.pitch;
    roll.Add(Degrees(e_roll)), pitch.Add(Degrees(e_pitch));
    if (Degrees(std::hypot(e_roll, e_pitch)) > kOutlier_deg) ++outliers;
    if (fix->roll_sigma > 0) {
      stated += 2;
      within += (std::abs(e_roll) <= 2 * fix->roll_sigma) + (std::abs(e_pitch) <= 2 * fix->pitch_sigma);
    }
    if (!fix->turned) continue;
    if (!zero) zero = truth_turned - *fix->turned;
    const double e_yaw = Degrees(*fix->turned - (truth_turned - *zero));
    yaw.Add(e_yaw), (row.exposure.t_s < middle_s ? early : late).Add(e_yaw);
  }
  if (fixes == 0) return;
  m[prefix + "attitude_share"] = static_cast<double>(fixes) / static_cast<double>(rows.size());
  m[prefix + "attitude_outliers"] = outliers;
  m[prefix + "roll_rmse_deg"] = roll.Root();
  m[prefix + "pitch_rmse_deg"] = pitch.Root();
  if (stated > 0) m[prefix + "attitude_within_2_sigma"] = static_cast<double>(within) / stated;
  if (yaw.count > 0) m[prefix + "yaw_rmse_deg"] = yaw.Root();
  if (early.count > 0) m[prefix + "yaw_rmse_first_half_deg"] = early.Root();
  if (late.count > 0) m[prefix + "yaw_rmse_second_half_deg"] = late.Root();
}

template <class Get>
TelemetryColumn Column(const char* name, Get get) {
  return {name, [get](const LogRow& row) -> std::optional<double> {
            const auto* report = ReportOf<HorizonReport>(row.decision);
            return report ? get(*report) : std::nullopt;
          }};
}

// In degrees, of the attitude or of the heading.
template <class Get>
TelemetryColumn Angle(const char* name, Get get) {
  return Column(name, [get](const HorizonReport& r) -> std::optional<double> {
    return r.attitude ? std::optional(Degrees(get(*r.attitude))) : std::nullopt;
  });
}
template <class Get>
TelemetryColumn Heading(const char* name, Get get) {
  return Column(name, [get](const HorizonReport& r) -> std::optional<double> {
    return r.attitude && r.attitude->turned ? std::optional(Degrees(get(*r.attitude))) : std::nullopt;
  });
}

}  // namespace

std::vector<TelemetryColumn> HorizonColumns() {
  using A = AttitudeFix;
  return {Angle("horizon_roll_deg", [](const A& a) { return a.roll; }),
          Angle("horizon_pitch_deg", [](const A& a) { return a.pitch; }),
          Angle("horizon_roll_sigma_deg", [](const A& a) { return a.roll_sigma; }),
          Angle("horizon_pitch_sigma_deg", [](const A& a) { return a.pitch_sigma; }),
          Heading("compass_turned_deg", [](const A& a) { return *a.turned; }),
          Heading("compass_sigma_deg", [](const A& a) { return a.turned_sigma; }),
          Column("horizon_coasting_s", [](const HorizonReport& r) { return r.coasting_s; })};
}

std::vector<Metric> HorizonMetrics() {
  const std::vector<Metric> own = {
      {"attitude_share", "1", "Share of the frames that gave an attitude", 0, 1},
      {"attitude_outliers", "1", "How many attitudes were wrong by more than 5 degrees"},
      {"attitude_within_2_sigma", "1",
       "Share of the rolls and pitches no farther off than two of their sigmas", 0, 1},
      {"roll_rmse_deg", "deg", "RMS error of the roll, at the exposures"},
      {"pitch_rmse_deg", "deg", "RMS error of the pitch, at the exposures"},
      {"yaw_rmse_deg", "deg", "RMS error of the heading since the first image that had one"},
      {"yaw_rmse_first_half_deg", "deg", "RMS error of the heading over the first half of that time"},
      {"yaw_rmse_second_half_deg", "deg", "RMS error of the heading over the second half of that time"}};
  std::vector<Metric> metrics = own;
  for (Metric metric : own) {
    metric.name = "baseline_" + metric.name;
    metric.description += ", by the reference method";
    metrics.push_back(std::move(metric));
  }
  return metrics;
}

void AddHorizonMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics) {
  AddAttitude(rows, &HorizonReport::attitude, "", metrics);
  AddAttitude(rows, &HorizonReport::baseline, "baseline_", metrics);
}

}  // namespace kestrel::mission
