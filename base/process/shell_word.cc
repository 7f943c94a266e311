// SPDX-License-Identifier: Apache-2.0
#include "base/process/shell_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace kestrel {

std::string ShellWord(const std::string& text) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) || std::string_view("_-+=./:,@%").find(static_cast<char>(c)) != std::string::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return text;
  std::string inside;
  for (const char c : text) {
    if (c == '\'') inside += "'\\'";
    inside += c;
  }
  return fmt::format("'{}'", inside);
}

}  // namespace kestrel
