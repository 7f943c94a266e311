// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/yaml/config.h"
#include "base/yaml/fields.h"

// What a scenario says of itself that may be changed in flight, and when it is.
namespace kestrel::flight {

// A key of the scenario that may be changed in flight. min, max: within its own valid range.
struct ChangeableKeys {
  std::string key;
  std::optional<double> min, max;
  std::vector<std::string> choices;
};

inline void Fields(FieldVisitor& v, ChangeableKeys& c) {
  v(Required("key",
             "key of this scenario that may be changed in flight, such as wind.mean_m_s or "
             "targets.0.velocity_m_s"),
    c.key);
  v({"min", "minimum of the value in flight; null: that of the key"}, c.min, -1e9, 1e9);
  v({"max", "maximum of the value in flight; null: that of the key"}, c.max, -1e9, 1e9);
  v({"choices", "values that are offered, each as YAML, and no other is taken; none: any that is valid"},
    c.choices);
}

// A change in flight: from the first frame on that has come by then, after the decision on it.
struct ChangeKeys {
  double at_s = 0;
  std::string key;
  ConfigNode value;
};

inline void Fields(FieldVisitor& v, ChangeKeys& c) {
  v({"at_s",
     "time of the flight of the change, which comes after the decision on the first frame from then on"},
    c.at_s, 0.0, 1e9);
  v(Required("key", "key of this scenario that is changed; it must be among those of changeable"), c.key);
  v(Required("value", "what it is from then on, as the scenario could have it from the beginning"), c.value);
}

}  // namespace kestrel::flight
