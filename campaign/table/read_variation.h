// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/config.h"
#include "base/yaml/fields.h"
#include "campaign/table/campaign_plan.h"

// What files of campaigns and of tunings have in common: a scenario, and what of it varies.
namespace kestrel::campaign {

// Most rows of a table.
constexpr int kMaxRows = 10'000'000;

// Where a value was written, or the nearest around it that was.
const Place& WhereIn(const ConfigNode& root, std::initializer_list<std::string_view> path);

// Whether a mistake of a key, or of one below it, is among them: what follows from it need not be said.
bool IsReported(const Mistakes& mistakes, const std::string& key);

// Overrides of a file's own keys, and those of its scenario's, which it may have in its `set`. What neither
// has is the one's whose keys are nearer.
struct SplitOverrides {
  std::vector<std::string> of_file, of_scenario;
};
SplitOverrides Split(const std::vector<std::string>& overrides, const std::vector<std::string>& keys);

// Adds overrides to a `set`, in which what they are of goes.
void SetInstead(const std::vector<std::string>& overrides, std::vector<std::string>& set);

// The keys that the Fields of a struct name.
class KeyNames final : public FieldVisitor {
 public:
  void Visit(const FieldKey& key, const FieldValue&) override { names.push_back(key.name); }
  std::vector<std::string> names;
};
template <class T>
std::vector<std::string> KeysOf() {
  KeyNames visitor;
  T nothing;
  Fields(visitor, nothing);
  return visitor.names;
}

// The members of `vary`, by the scenario's key: `key: {uniform: [0, 6]}`; keys may be nested too.
std::map<std::string, Distribution> ReadVary(const ConfigNode& vary, Mistakes& mistakes);

// A name of the plan that none is given for becomes the file's own, a scenario beside the file its whole
// path. Then what does not fit together: a scenario that is not valid with `set`, a key that it does not
// have, a value that can come and that it refuses (it is loaded with each extreme), a key both set and
// varied, groups that cannot be correlated, a table that is too long. Whether the scenario is valid with
// `set`, so that more can be tried in it.
bool ResolveVariation(const std::filesystem::path& file, const ConfigNode& root, CampaignPlan& plan,
                      Mistakes& mistakes);

// Whether the scenario takes each of these sets of overrides.
bool TakesAll(const CampaignPlan& plan, const std::vector<std::vector<std::string>>& sets);

// Whether the scenario takes "key=value" after other overrides; otherwise says why.
bool CheckOverride(const CampaignPlan& plan, const std::vector<std::string>& others, const std::string& key,
                   const std::string& value, const Place& where, const std::string& path,
                   std::string_view remedy, Mistakes& mistakes);

}  // namespace kestrel::campaign
