// SPDX-License-Identifier: Apache-2.0
#include "scenarios/stabilise/stabilise_metrics.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "scenarios/stabilise/corner_motion.h"
#include "scenarios/stabilise/stabilise_report.h"

namespace kestrel::scenarios {
namespace {

template <class Get>
mission::TelemetryColumn Column(const char* name, Get get) {
  return {name, [get](const mission::LogRow& row) -> std::optional<double> {
            const auto* report = mission::ReportOf<StabiliseReport>(row.decision);
            if (!report || !report->shown) return std::nullopt;
            return get(*report->shown, row);
          }};
}

bool IsMeasured(vision::StabilisedState state) {
  using State = vision::StabilisedState;
  return state != State::kTextureless && state != State::kNoAttitude && state != State::kCut &&
         state != State::kResized;
}

// Over the corners, of both coordinates.
double Jitter_px(const std::vector<CornerFlow>& flows, std::array<Eigen::Vector2d, 4> CornerFlow::*of,
                 double rate_hz) {
  double sum = 0;
  for (std::size_t corner = 0; corner < 4; ++corner)
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double> steps;
      for (const CornerFlow& flow : flows) steps.push_back((flow.*of)[corner][axis]);
      const double rms = BandRms(steps, rate_hz, kJitterFrom_hz, kJitterUntil_hz);
      sum += rms * rms;
    }
  return std::sqrt(sum / 4);
}

}  // namespace

std::vector<mission::TelemetryColumn> StabiliseColumns() {
  return {
      Column("stabilised_sequence",
             [](const ShownImage& s, const mission::LogRow&) { return static_cast<double>(s.sequence); }),
      Column("stabilised_inliers", [](const ShownImage& s, const mission::LogRow&) { return s.inliers; }),
      Column("stabilised_strength", [](const ShownImage& s, const mission::LogRow&) { return s.strength; }),
      Column("stabilised_by_opencl",
             [](const ShownImage& s, const mission::LogRow&) { return s.by_opencl; })};
}

std::vector<mission::Metric> StabiliseMetrics() {
  return {
      {"jitter_in_px", "px", "RMS motion of the corners of the view from 0.5 to 15 Hz, as it came in"},
      {"jitter_out_px", "px", "The same of the stabilised view"},
      {"jitter_left", "1", "Share of the motion of the corners from 0.5 to 15 Hz that is left"},
      {"stabilised_share", "1", "Share of the stabilised images whose motion was measured", 0, 1},
      {"drawn_back_share", "1",
       "Share of the stabilised images whose view was drawn back from its smooth path to stay within the "
       "image",
       0, 1},
      {"stabilised_late_s", "s", "Longest time from the exposure of an image until it was there stabilised"}};
}

void AddStabiliseMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics) {
  int shown = 0, measured = 0, drawn_back = 0;
  double late_s = 0;
  for (const mission::LogRow& row : rows) {
    const auto* report = mission::ReportOf<StabiliseReport>(row.decision);
    if (!report || !report->shown) continue;
    ++shown;
    measured += IsMeasured(report->shown->state);
    drawn_back += report->shown->strength < 1;
    late_s = std::max(late_s, row.now.t_s - report->shown->t_s);
  }
  if (shown == 0) return;
  metrics["stabilised_share"] = static_cast<double>(measured) / shown;
  metrics["drawn_back_share"] = static_cast<double>(drawn_back) / shown;
  metrics["stabilised_late_s"] = late_s;
  const std::vector<CornerFlow> flows = CornerFlows(rows);
  if (flows.size() < 2) return;
  const double rate_hz = static_cast<double>(flows.size() - 1) / (flows.back().t_s - flows.front().t_s);
  const double in = Jitter_px(flows, &CornerFlow::in, rate_hz),
               out = Jitter_px(flows, &CornerFlow::out, rate_hz);
  metrics["jitter_in_px"] = in;
  metrics["jitter_out_px"] = out;
  if (in > 0) metrics["jitter_left"] = out / in;
}

}  // namespace kestrel::scenarios
