// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "campaign/execution/result_store.h"
#include "campaign/statistics/campaign_summary.h"

namespace kestrel::campaign {

// How a search for gains went, one of several by a method.
struct SearchCurve {
  std::string method;                 // "CMA-ES", "cross-entropy", "random search"
  int repetition = 1;                 // of the method, from 1
  std::vector<double> flights, cost;  // after so many flights, rising, as Stages() of campaign/tuning/tune.h
  std::optional<double> held_out = {};  // cost of what it found on rows that no search saw
};

struct TunedGain {
  std::string key;
  double start = 0, tuned = 0;  // before and after
  double low = 0, high = 0;     // where it was looked for
  bool log = false;             // the search was on a logarithmic scale
};

struct TuningHistory {
  std::string cost;                  // what it is made of
  std::optional<double> start_cost;  // of what the search started from, on rows that no search saw
  std::string verdict;               // a sentence: how the tuned gains did against them; may be empty
  std::vector<SearchCurve> searches;
  std::vector<TunedGain> gains;
};

// What a page tells of.
struct ReportSubject {
  CampaignIdentity identity;
  std::vector<RunResult> results;  // in the order of the rows
  CampaignSummary summary;         // of them
  std::string results_file;        // records are looked for beside it too, in recordings/
  std::string replay;              // the command that flies a row again, but for the row's number at its end
  std::string run;                 // where there is none: one that does, but for its keys as --set at the end
  std::string again;               // the command that flies all of it again; may be empty
  std::optional<TuningHistory> tuning;  // then the results are those of the tuned gains on rows unseen
};

// A page of HTML that holds everything it shows but the videos of recorded runs, which it links relative to
// its own folder: it works from a file, without a network. The same subject gives the same page. Throws
// std::runtime_error: the page's own files (campaign/report/page/ of a data folder) or Chart.js, of Debian's
// package libjs-chart.js, are not there.
std::string HtmlReport(const ReportSubject& subject, const std::filesystem::path& page_folder);

}  // namespace kestrel::campaign
