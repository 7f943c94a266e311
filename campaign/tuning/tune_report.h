// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "campaign/report/html_report.h"
#include "campaign/tuning/tune.h"

namespace kestrel::campaign {

// A search that came to its end.
struct Searched {
  LoadedTune tune;
  TuneResult result;
  std::vector<RunResult> runs;  // of the gains found, on the held-out rows
};

// What a page tells of searches by the same rows held out: how each went, and what the gains of the first do.
// folder: where that one's gains.yaml is; again: the command that searches again.
ReportSubject TuneSubject(const std::vector<Searched>& searches, const std::filesystem::path& folder,
                          const std::string& again);

// Searches by several methods, each some times, side by side: cost on the held-out rows, medians, and the
// constraints that their gains do not keep to.
std::string ComparisonText(const std::vector<Searched>& searches);

}  // namespace kestrel::campaign
