// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/fields.h"
#include "campaign/table/campaign_plan.h"
#include "campaign/table/sample_table.h"
#include "campaign/tuning/flight_cost.h"

namespace kestrel::campaign {

// A key of the scenario that is tuned.
struct Gain {
  double low = 0, high = 1;
  bool log = false;
  std::optional<double> start;
};

inline void Fields(FieldVisitor& v, Gain& g) {
  v(Required("low", "lower bound of the search, itself valid"), g.low, -1e9, 1e9);
  v(Required("high", "upper bound of the search, itself valid"), g.high, -1e9, 1e9);
  v({"log", "search on a logarithmic scale; low must be above 0"}, g.log);
  v({"start", "value from which the search starts; not given: that of the scenario"}, g.start, -1e9, 1e9);
}

// A tuning's file. What varies from flight to flight is as in a campaign's: flights.runs is of its `rows`.
struct TunePlan {
  CampaignPlan flights;
  std::map<std::string, Gain> gains;
  FlightCost cost;
  std::string method = "cma_es";
  int budget = 500;
  int rows = 2;
  int leaders = 5;
  int fresh_rows = 10;
  int held_out_rows = 50;
  std::uint64_t held_out_seed = 1;
};

// The keys of its file.
std::vector<FieldDescription> DescribeTuneFile();

struct LoadedTune {
  TunePlan plan;
  std::string text;                   // of the file
  std::map<std::string, double> own;  // gains as the scenario has them
  std::vector<std::string> others;    // "key=value" of the file of gains that it names, but for those tuned
  SampleTable fresh, held_out;
};

// What the candidates of a round fly. Round 0: the gains that the search starts from, and all that a search
// asks for which compares its rounds.
SampleTable RowsOfRound(const TunePlan& plan, int round);

// Reads a tuning's file and draws its tables. Throws InputError with every mistake of it, those of what
// varies as in LoadCampaign: a gain that the scenario does not have, bounds or a start that it refuses or
// that leave each other, a budget in which nothing can be found, a metric that no run has.
LoadedTune LoadTune(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace kestrel::campaign
