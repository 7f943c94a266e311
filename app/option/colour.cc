// SPDX-License-Identifier: Apache-2.0
#include "app/option/colour.h"

#include <fmt/color.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace kestrel::app {
namespace {

std::string In(fmt::terminal_color colour, const std::string& text, bool colours) {
  return colours ? fmt::format(fmt::fg(colour) | fmt::emphasis::bold, "{}", text) : text;
}

}  // namespace

bool TakesColours(std::FILE* stream) {
  const char *none = std::getenv("NO_COLOR"), *terminal = std::getenv("TERM");
  return isatty(fileno(stream)) && !(none && *none) && terminal && std::string_view(terminal) != "dumb";
}

std::string Green(const std::string& text, bool colours) {
  return In(fmt::terminal_color::green, text, colours);
}

std::string Red(const std::string& text, bool colours) { return In(fmt::terminal_color::red, text, colours); }

}  // namespace kestrel::app
