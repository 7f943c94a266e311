// SPDX-License-Identifier: Apache-2.0
#include "app/option/within.h"

#include <fmt/format.h>

#include <charconv>
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

CLI::Validator WholeNumber(int least, int most) {
  return CLI::Validator(
      [least, most](std::string& text) {
        int value = 0;
        const char* last = text.data() + text.size();
        const auto end = std::from_chars(text.data(), last, value);
        if (end.ec == std::errc{} && end.ptr == last && value >= least && value <= most) return std::string();
        return fmt::format("'{}' is not valid; valid: a whole number, {} to {}", text, least, most);
      },
      fmt::format("INT in [{} - {}]", least, most), "");
}

}  // namespace kestrel::app
