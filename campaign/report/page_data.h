// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "campaign/report/html_report.h"

namespace kestrel::campaign {

// The data of a page as JSON that may stand within a script element. Numbers read back to the same bits; what
// is not finite is null.
//   name, version, table_hash, scenario (its name), results_file, replay, run, again
//   plan_text, scenario_text
//   summary       that of campaign/statistics/campaign_summary.h
//   limits        {metric: {max, min}} of the scenario's criteria
//   keys          of the sample table
//   metrics       names: the listed ones first
//   runs          [{row, status, outcome, values: [text of each key], metrics: [number or null], state_hash,
//                 image_hash, log?, recording?, video?}]: the last two relative to the page
//   trajectories  [{row, t_s, north_m, east_m, height_m}] of recorded runs, those that did not pass first
//   tuning        null, or {cost, start_cost, verdict, gains: [{key, start, tuned, low, high,
//                 log}], searches: [{method, repetition, flights, cost, held_out or null}]}
std::string PageData(const ReportSubject& subject, const std::filesystem::path& page_folder);

}  // namespace kestrel::campaign
