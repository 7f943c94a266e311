// SPDX-License-Identifier: Apache-2.0
#include "mission/mosaic/mosaic_records.h"

#include <optional>

#include "mission/mosaic/mosaic_report.h"

namespace kestrel::mission {
namespace {

template <class Get>
TelemetryColumn Column(const char* name, Get get) {
  return {name, [get](const LogRow& row) -> std::optional<double> {
            const auto* report = ReportOf<MosaicReport>(row.decision);
            if (!report || !report->step) return std::nullopt;
            return get(*report);
          }};
}

}  // namespace

std::vector<TelemetryColumn> MosaicColumns() {
  return {Column("mosaic_images", [](const MosaicReport& r) { return r.placed; }),
          Column("mosaic_keyframes", [](const MosaicReport& r) { return r.keyframes; }),
          Column("mosaic_loops", [](const MosaicReport& r) { return r.loops; }),
          Column("mosaic_agreed", [](const MosaicReport& r) { return r.step->agreed; }),
          Column("mosaic_residual_px", [](const MosaicReport& r) { return r.step->rms_px; }),
          Column("mosaic_moved_px", [](const MosaicReport& r) { return r.step->moved_px; })};
}

std::vector<Metric> MosaicMetrics() {
  return {{"mosaic_images", "1", "Images that were given to the mosaic"},
          {"mosaic_share", "1", "Share of them that found their place in it", 0, 1},
          {"mosaic_keyframes", "1", "Keyframes of the mosaic"},
          {"mosaic_loops", "1", "Times that a keyframe was joined to an older one that shows the same"}};
}

void AddMosaicMetrics(const std::vector<LogRow>& rows, std::map<std::string, double>& metrics) {
  const MosaicReport* last = nullptr;
  for (const LogRow& row : rows)
    if (const auto* report = ReportOf<MosaicReport>(row.decision)) last = report;
  if (!last || last->offered == 0) return;
  metrics["mosaic_images"] = last->offered;
  metrics["mosaic_share"] = static_cast<double>(last->placed) / last->offered;
  metrics["mosaic_keyframes"] = last->keyframes;
  metrics["mosaic_loops"] = last->loops;
}

}  // namespace kestrel::mission
