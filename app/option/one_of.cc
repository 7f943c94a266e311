// SPDX-License-Identifier: Apache-2.0
#include "app/option/one_of.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "base/nearest_name.h"
#include "base/yaml/yaml_fields.h"

namespace kestrel::app {

CLI::Validator OneOf(std::vector<std::string> words) {
  std::string all = fmt::format("{{{}}}", fmt::join(words, ","));
  return CLI::Validator(
      [words = std::move(words)](std::string& text) {
        if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
        const auto near = NearestName(text, words);
        return fmt::format("'{}' is not valid; {}", text,
                           near ? fmt::format("did you mean '{}'?", *near)
                                : fmt::format("valid: {}", fmt::join(words, ", ")));
      },
      std::move(all), "");
}

}  // namespace kestrel::app
