// SPDX-License-Identifier: Apache-2.0
#include "scenarios/landing_deck/deck_records.h"

#include <algorithm>
#include <cmath>

#include "geometry/tait_bryan.h"
#include "mission/mean_square.h"

namespace kestrel::scenarios {
namespace {

constexpr double kLanded_m = 0.3;

double TiltOf(const Pose& X_NT) {
  return Degrees(std::acos(std::clamp((X_NT.R * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0)));
}

template <class Get>
mission::TelemetryColumn OfTruth(const char* name, Get get) {
  return {name, [get](const mission::LogRow& row) -> std::optional<double> { return get(row.now); }};
}

template <class Get>
mission::TelemetryColumn OfEstimate(const char* name, Get get) {
  return {name, [get](const mission::LogRow& row) -> std::optional<double> {
            const auto* report = mission::ReportOf<DeckReport>(row.decision);
            if (!report || !report->deck) return std::nullopt;
            return get(*report->deck);
          }};
}

template <class Get>
mission::TelemetryColumn OfTouch(const char* name, Get get) {
  return {name, [get](const mission::LogRow& row) -> std::optional<double> {
            const auto* report = mission::ReportOf<DeckReport>(row.decision);
            if (!report || !report->touch) return std::nullopt;
            return get(*report->touch);
          }};
}

}  // namespace

std::vector<mission::TelemetryColumn> DeckColumns() {
  using Deck = control::DeckEstimator::Deck;
  using Touch = mission::ExpectedTouch;
  const auto angles = [](const Truth& t) { return TaitBryanFromRotation(t.X_NT.R.toRotationMatrix()); };
  std::vector<mission::TelemetryColumn> columns = {
      OfTruth("deck_x_m", [](const Truth& t) { return t.X_NT.p.x(); }),
      OfTruth("deck_y_m", [](const Truth& t) { return t.X_NT.p.y(); }),
      OfTruth("deck_z_m", [](const Truth& t) { return t.X_NT.p.z(); }),
      OfTruth("deck_vx_m_s", [](const Truth& t) { return t.v_NT.x(); }),
      OfTruth("deck_vy_m_s", [](const Truth& t) { return t.v_NT.y(); }),
      OfTruth("deck_vz_m_s", [](const Truth& t) { return t.v_NT.z(); }),
      OfTruth("deck_yaw_deg", [=](const Truth& t) { return Degrees(angles(t).yaw); }),
      OfTruth("deck_pitch_deg", [=](const Truth& t) { return Degrees(angles(t).pitch); }),
      OfTruth("deck_roll_deg", [=](const Truth& t) { return Degrees(angles(t).roll); }),
      OfEstimate("deck_estimate_vx_m_s", [](const Deck& d) { return d.v_N.x(); }),
      OfEstimate("deck_estimate_vy_m_s", [](const Deck& d) { return d.v_N.y(); }),
      OfEstimate("deck_estimate_vz_m_s", [](const Deck& d) { return d.v_N.z(); }),
      OfEstimate("deck_estimate_tilt_deg",
                 [](const Deck& d) { return Degrees(std::acos(std::min(1.0, d.normal_N.z()))); }),
      OfEstimate("deck_estimate_sigma_m", [](const Deck& d) { return d.sigma_m; }),
      OfTouch("expected_tilt_deg", [](const Touch& t) { return Degrees(t.tilt); }),
      OfTouch("expected_sink_m_s", [](const Touch& t) { return t.sink_m_s; }),
      OfTouch("expected_speed_m_s", [](const Touch& t) { return t.speed_m_s; })};
  for (mission::TelemetryColumn& column : mission::TouchDownColumns()) columns.push_back(std::move(column));
  return columns;
}

std::vector<mission::Metric> DeckMetrics() {
  std::vector<mission::Metric> metrics = mission::TouchDownMetrics();
  metrics.push_back(
      {"landed_on_deck", "1", "1 if it landed on the deck within 0.3 m of the pad's centre", 0, 1});
  metrics.push_back({"rendezvous_s", "s", "When it was first within 1 m of the pad's centre, level"});
  metrics.push_back(
      {"follow_error_m", "m", "RMS level distance from the pad's centre, from then to the touch"});
  metrics.push_back({"deck_max_tilt_deg", "deg", "Maximum tilt of the deck from level", 0, 180});
  metrics.push_back({"deck_heave_rms_m_s", "m/s", "RMS velocity of the deck, up and down"});
  metrics.push_back({"deck_max_speed_m_s", "m/s", "Maximum level speed of the deck"});
  return metrics;
}

void AddDeckMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& m) {
  mission::AddTouchDownMetrics(rows, m);
  mission::MeanSquare heave, off;
  double tilt = 0, speed = 0;
  std::optional<double> met_s;
  bool touched = false;
  for (const mission::LogRow& row : rows) {
    tilt = std::max(tilt, TiltOf(row.now.X_NT));
    speed = std::max(speed, row.now.v_NT.head<2>().norm());
    heave.Add(row.now.v_NT.z());
    const double from = (row.now.X_NB.p - row.now.X_NT.p).head<2>().norm();
    if (from < 1 && !met_s) met_s = row.now.t_s;
    touched = touched || row.now.touching;
    if (met_s && !touched) off.Add(from);
  }
  m["deck_max_tilt_deg"] = tilt;
  m["deck_max_speed_m_s"] = speed;
  m["deck_heave_rms_m_s"] = heave.Root();
  if (met_s) m["rendezvous_s"] = *met_s;
  if (off.count > 0) m["follow_error_m"] = off.Root();
  const bool landed = !rows.empty() && rows.back().estimate.landed;
  m["landed_on_deck"] = landed && m.contains("rest_error_m") && m.at("touchdown_error_m") < kLanded_m &&
                        rows.back().now.touching;
}

}  // namespace kestrel::scenarios
