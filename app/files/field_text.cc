// SPDX-License-Identifier: Apache-2.0
#include "app/files/field_text.h"

#include <fmt/format.h>

#include <cctype>

namespace kestrel::app {

std::string AsSentence(const std::string& phrase) {
  std::string sentence = phrase;
  // A word with a capital or a sign in it is a name or a symbol.
  if (sentence.size() > 1 && (sentence[1] == ' ' || std::islower(static_cast<unsigned char>(sentence[1]))))
    sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
  return sentence + '.';
}

std::string TypeAndDefault(const FieldDescription& f) {
  if (f.required) return TypeText(f) + ", must be given";
  if (f.value.empty() || f.value == "\"\"") return TypeText(f);
  return fmt::format("{}, by default {}", TypeText(f),
                     f.value == "[]" || f.value == "{}" ? "empty" : f.value);
}

}  // namespace kestrel::app
