// SPDX-License-Identifier: Apache-2.0
#include "base/printable.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace kestrel {
namespace {

bool IsC1(std::string_view text) {  // U+0080 to U+009F: CSI, which is as good as ESC [, is one of them
  return text.size() >= 2 && text[0] == '\xc2' && static_cast<unsigned char>(text[1]) < 0xa0;
}

// How many bytes the letter in UTF-8 has that begins a text; 0: it begins with none, or with one that is no
// letter but a command to the terminal.
std::size_t LetterBytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return (first >= 0x20 && first != 0x7f) || first == '\n' || first == '\t' ? 1 : 0;
  const std::size_t bytes = first >= 0xc2 && first <= 0xdf   ? 2
                            : first >= 0xe0 && first <= 0xef ? 3
                            : first >= 0xf0 && first <= 0xf4 ? 4
                                                             : 0;
  if (bytes > text.size()) return 0;
  for (std::size_t i = 1; i < bytes; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  return IsC1(text) ? 0 : bytes;
}

}  // namespace

bool HasControl(std::string_view text) {
  for (; !text.empty(); text.remove_prefix(1)) {
    const auto c = static_cast<unsigned char>(text[0]);
    if (c < 0x20 || c == 0x7f || IsC1(text)) return true;
  }
  return false;
}

std::string Printable(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t bytes = LetterBytes(text);
    shown += bytes > 0 ? std::string(text.substr(0, bytes))
                       : fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
  return shown;
}

}  // namespace kestrel
