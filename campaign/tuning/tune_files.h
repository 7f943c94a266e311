// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "campaign/tuning/tune.h"

namespace kestrel::campaign {

// The gains as a file that scenarios take (`gains: FILE`) instead of the one that they had: a line of
// "key: value" for each, and in comments where they are from: the command; version, of the program.
std::string GainsFile(const LoadedTune& tune, const TuneResult& result, const std::string& command,
                      const std::string& version);

// JSON, for reports: name, scenario, method, seed, budget, flights, gains {key: {low, high, log, start, own,
// tuned}}, compares_rounds (all on the same rows), search and leaders [{round, flights, gains {key: value},
// cost, costs, passed, kept}], held_out {seed, start | tuned | own: {gains, cost, costs, passed}, from_start
// | from_own: {difference, low, high}, better}. kept: by the metric of a constraint, how many flights kept to
// it. own and from_own only where the start is not what the scenario has.
std::string TuneJson(const LoadedTune& tune, const TuneResult& result, const std::string& version);

// A sentence for each constraint that is not kept to in every held-out flight with the gains found.
std::vector<std::string> BrokenConstraints(const LoadedTune& tune, const TuneResult& result);

// Whether the gains found are better than those it began with, and than the scenario's own, how they keep to
// each constraint, or that no candidate ever did, and whether all candidates cost the same; sentences.
std::string VerdictText(const LoadedTune& tune, const TuneResult& result);

// What came of it, for people.
std::string TuneText(const LoadedTune& tune, const TuneResult& result);

}  // namespace kestrel::campaign
