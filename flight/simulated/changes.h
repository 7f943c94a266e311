// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/config.h"
#include "flight/simulated/scenario.h"
#include "mission/mission.h"
#include "records/page/flight_subject.h"
#include "sim/simulator.h"

namespace kestrel::flight {

// A change that was made. Values are JSON, as they were given: without defaults.
struct MadeChange {
  double t_s = 0;
  std::string key, before, value;
  bool by_hand = false;  // not in the scenario before
};

// What is changed in a flight that goes on: what its scenario says, and what somebody asks for. A change comes
// between the decision on a frame and the next step of the world, and depends on nothing else: a flight by
// flown() is the same as this one, bit for bit.
class Changes {
 public:
  // mission: null while nobody flies by it; its keys cannot be changed then. told: of each change, as it is made. All
  // must outlive it.
  Changes(const LoadedScenario& loaded, sim::Simulator& simulator, mission::Mission* mission,
          std::function<void(const MadeChange&)> told = nullptr);

  // From now on this is who flies, by the keys as they are now.
  void FlyBy(mission::Mission* mission);

  // To be called after the decision on each frame: makes the changes of the scenario that are due.
  void MakeDue();
  // Changes a key; value: YAML, which JSON is too. What is due comes first. Returns why it cannot be done, in a
  // sentence, and nothing is changed then; empty: it is done. To be called where MakeDue() is.
  std::string Make(const std::string& key, const std::string& value);

  // What may be changed now, and the values as they are.
  std::vector<records::ChangeableKey> All() const;
  // The scenario as it began, with all changes that were made and that are still to come.
  const Scenario& flown() const { return flown_; }

 private:
  void Apply(const ChangeKeys& change, const Scenario& changed, bool by_hand);

  const LoadedScenario& loaded_;
  sim::Simulator& simulator_;
  mission::Mission* mission_;
  std::function<void(const MadeChange&)> told_;
  Scenario flown_, now_;
  std::map<std::string, std::string> told_values_;  // of keys that were changed, as they were written
  std::size_t next_ = 0;                            // of flown_.changes, which are in the order of time
};

// That `changeable` names keys that can be changed, and `changes` such as are among them and valid one after
// the other; the latter are then in the order of time.
void CheckChanges(const LoadedScenario& loaded, Scenario& scenario, const Config& config, const Place& file,
                  Mistakes& mistakes);

}  // namespace kestrel::flight
