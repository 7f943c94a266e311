// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/describe_fields.h"
#include "base/yaml/fields.h"
#include "campaign/table/distribution.h"
#include "campaign/table/sample_table.h"

namespace kestrel::campaign {

// Keys of which the values are drawn together: their ranks correlate by this much, each with each.
struct CorrelatedGroup {
  std::vector<std::string> keys;
  double rank_correlation = 0;
  bool operator==(const CorrelatedGroup&) const = default;
};

inline void Fields(FieldVisitor& v, CorrelatedGroup& g) {
  v(Required("keys", "varied keys whose values are drawn together"), g.keys);
  v(Required("rank_correlation", "rank correlation of each two of these keys"), g.rank_correlation, -1.0,
    1.0);
}

// A key that takes in each row the value of one that varies.
struct SameValue {
  std::string key, as;
  bool operator==(const SameValue&) const = default;
};

inline void Fields(FieldVisitor& v, SameValue& s) {
  v(Required("key", "key of the scenario that takes the value"), s.key);
  v(Required("as", "varied key whose value it takes in each flight"), s.as);
}

// What a campaign's results must keep to, for CI: judged by the bound of the 95 % interval that is against
// it.
struct Threshold {
  std::optional<double> quantile;
  std::optional<double> max, min;
  bool operator==(const Threshold&) const = default;
};

inline void Fields(FieldVisitor& v, Threshold& t) {
  v({"quantile", "quantile of the metric that is judged, between 0 and 1; not given: its mean"}, t.quantile,
    0.0, 1.0);
  v({"max", "limit that the upper bound of the 95 % interval must not exceed"}, t.max, -1e9, 1e9);
  v({"min", "limit that the lower bound of the 95 % interval must not go below"}, t.min, -1e9, 1e9);
}

// A campaign's file.
struct CampaignPlan {
  std::string name;
  std::string scenario;
  std::vector<std::string> set;
  int runs = 100;
  std::uint64_t seed = 1;
  std::string sampling = "latin_hypercube";
  std::map<std::string, Distribution> vary;
  std::vector<CorrelatedGroup> correlated;
  std::vector<SameValue> same;
  std::vector<std::string> metrics;
  double limit_s = 600;
  std::map<std::string, Threshold> thresholds;
  bool operator==(const CampaignPlan&) const = default;
};

// The keys of its file.
std::vector<FieldDescription> DescribeCampaignFile();

// Why no value keeps to both.
std::string NoneBetween(double min, double max);

struct LoadedCampaign {
  CampaignPlan plan;
  std::string text;  // of the file, and a NoteOfOverride for each override that makes a difference
  SampleTable table;
  std::string file = {};  // whole path
};

// A line of YAML below a file's text that says "key=value" stands instead of what the file has, as a comment;
// and those that a text has.
std::string NoteOfOverride(const std::string& override);
std::vector<std::string> OverridesNotedIn(const std::string& text);

// Reads a campaign's file and draws its table. overrides: of the file's own keys; one of a key that its
// scenario has, and the file does not, stands in its `set`. Throws InputError with every mistake of it: a key
// that the scenario does not have, a distribution that can leave the key's range, an empty grid.
LoadedCampaign LoadCampaign(const std::filesystem::path& file,
                            const std::vector<std::string>& overrides = {});

}  // namespace kestrel::campaign
