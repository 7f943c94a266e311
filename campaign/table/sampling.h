// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "campaign/table/campaign_plan.h"
#include "campaign/table/sample_table.h"

namespace kestrel::campaign {

// The table of a valid plan, from nothing but the plan. Of grids: every combination of their values, the last
// key's changing first, and all of them again `runs` times, the other keys drawn anew for each row; at each
// combination the sampling is one of its own, of `runs`. Those other keys are drawn
//   independent      each row for itself
//   latin_hypercube  one row in each of `runs` equally likely strata of each key (McKay et al. 1979)
//   sobol            ScrambledSobol, a dimension for each key in their order; best with a power of two of
//   runs
// A correlated group is a Gaussian copula of which the rank correlation (Spearman's) is the one asked for:
// that of the normals under it is 2 sin(pi r / 6). In a Latin hypercube its keys' own values are rearranged
// to the copula's ranks.
//
// What stays: a key's values depend on the seed and on its own name (independent and Latin hypercube), and on
// how many keys come before it in the alphabet (sobol), so another key leaves the others as they were; the
// first of more runs are those of fewer (independent and sobol). A key of a group depends on those before it
// in the group too.
SampleTable DrawTable(const CampaignPlan& plan);

// The seed of a row's scenario: two rows of a campaign never have the same.
std::uint64_t SeedOfRow(std::uint64_t campaign_seed, std::int64_t row);

// Of the normals of a Gaussian copula, and the bounds, open, of what a group of so many keys can have, each
// with each.
double CopulaCorrelation(double rank_correlation);
double MinRankCorrelation(int keys);

}  // namespace kestrel::campaign
