// SPDX-License-Identifier: Apache-2.0
#include "control/law/fuzzy/fuzzy_rule.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <sstream>

namespace kestrel::control {
namespace {

constexpr std::string_view kWords[] = {"if", "is", "and", "then"};

bool IsWord(std::string_view word) {
  return std::find(std::begin(kWords), std::end(kWords), word) != std::end(kWords);
}

std::vector<std::string> WordsOf(std::string_view text) {
  std::istringstream stream{std::string(text)};
  return {std::istream_iterator<std::string>(stream), {}};
}

}  // namespace

bool IsFuzzyName(std::string_view name) {
  const std::vector<std::string> words = WordsOf(name);
  return words.size() == 1 && words[0] == name && !IsWord(name);
}

// rule = "if" clauses "then" clauses; clauses = clause {"and" clause}; clause = NAME "is" NAME
ParsedRule ParseRule(std::string_view text) {
  const std::vector<std::string> words = WordsOf(text);
  std::size_t next = 0;
  std::string wrong;
  const auto expect = [&](std::string_view what) {
    if (wrong.empty())
      wrong = next < words.size() ? fmt::format("has '{}' where {} should stand", words[next], what)
                                  : fmt::format("ends where {} should stand", what);
  };
  const auto word = [&](std::string_view wanted) {
    if (wrong.empty() && next < words.size() && words[next] == wanted) return ++next, true;
    return false;
  };
  const auto name = [&](std::string_view what) -> std::string {
    if (wrong.empty() && next < words.size() && !IsWord(words[next])) return words[next++];
    return expect(what), "";
  };
  const auto clauses = [&] {
    std::vector<FuzzyClause> all;
    do {
      FuzzyClause clause;
      clause.variable = name("the name of a variable");
      if (!word("is")) expect("'is'");
      clause.set = name("the name of a set");
      all.push_back(std::move(clause));
    } while (word("and"));
    return all;
  };
  FuzzyRule rule;
  if (!word("if")) expect("'if'");
  rule.conditions = clauses();
  if (!word("then")) expect("'and' or 'then'");
  rule.conclusions = clauses();
  if (next < words.size()) expect("'and' or the end");
  if (!wrong.empty()) return {std::nullopt, wrong};
  return {std::move(rule), ""};
}

}  // namespace kestrel::control
