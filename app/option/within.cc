// SPDX-License-Identifier: Apache-2.0
#include "app/option/within.h"

#include <fmt/format.h>

#include <string>

namespace kestrel::app {

CLI::Validator Within(double least, double most) {
  return CLI::Validator(
      [least, most](std::string& text) {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return std::string();
        return fmt::format("'{}' is not valid; valid: {:g} to {:g}", text, least, most);
      },
      fmt::format("FLOAT in [{:g} - {:g}]", least, most), "");
}

}  // namespace kestrel::app
