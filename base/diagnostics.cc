// SPDX-License-Identifier: Apache-2.0
#include "base/diagnostics.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/printable.h"

namespace kestrel {
namespace {

// What is shown of many mistakes, and of a long one: nobody reads more, and a terminal chokes on it.
constexpr std::size_t kMaxShown = 50, kLongestShown = 2000;

// The beginning and the end, between which the middle is left out: a place stands first, and what would be
// valid last.
std::string Shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  return fmt::format("{} [...] {}", std::string_view(text).substr(0, most / 2),
                     std::string_view(text).substr(text.size() - most / 2));
}

std::string Shown(const std::vector<Diagnostic>& all) {
  std::string shown;
  for (std::size_t i = 0; i < std::min(all.size(), kMaxShown); ++i) {
    if (i > 0) shown += '\n';
    shown += Shortened(all[i].Text(), kLongestShown);
  }
  if (all.size() > kMaxShown) shown += fmt::format("\nand {} more", all.size() - kMaxShown);
  return shown;
}

}  // namespace

std::string Place::Text() const { return line > 0 ? fmt::format("{}:{}", file, line) : file; }

std::string Diagnostic::Text() const {
  std::string text = place().Text();
  for (const std::string& part : {key, what})
    if (!part.empty()) text += (text.empty() ? "" : ": ") + part;
  return remedy.empty() ? text : text + "; " + remedy;
}

InputError::InputError(std::vector<Diagnostic> all)
    : std::runtime_error(Printable(Shown(all))), diagnostics(std::move(all)) {}

InputError::InputError(const Place& where, std::string_view what, std::string_view remedy)
    : InputError(
          std::vector{Diagnostic{where.file, where.line, "", std::string(what), std::string(remedy)}}) {}

void Mistakes::Add(const Place& where, std::string_view key, std::string_view what, std::string_view remedy) {
  all_.push_back({where.file, where.line, std::string(key), std::string(what), std::string(remedy)});
}

void Mistakes::Add(const InputError& error) {
  all_.insert(all_.end(), error.diagnostics.begin(), error.diagnostics.end());
}

void Mistakes::Add(const InputError& error, const Place& where) {
  for (const Diagnostic& each : error.diagnostics) {
    Diagnostic there = each;
    there.remedy.clear();
    Add(where, "", there.Text(), each.remedy);
  }
}

std::vector<std::string> Mistakes::Texts() const {
  std::vector<std::string> texts;
  for (const Diagnostic& each : all_) texts.push_back(each.Text());
  return texts;
}

void Mistakes::ThrowIfAny() const {
  if (!all_.empty()) throw InputError(all_);
}

}  // namespace kestrel
