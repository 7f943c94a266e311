// SPDX-License-Identifier: Apache-2.0
#include "app/option/command_tree.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <sstream>

namespace kestrel::app {

std::vector<const CLI::App*> VerbsOf(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App* each) { return !each->get_group().empty(); });
}

std::vector<const CLI::Option*> OptionsOf(const CLI::App& command) {
  return command.get_options(
      [](const CLI::Option* each) { return each->nonpositional() && !each->get_group().empty(); });
}

std::vector<const CLI::Option*> PositionalsOf(const CLI::App& command) {
  return command.get_options([](const CLI::Option* each) { return each->get_positional(); });
}

std::string PathOf(const CLI::App& command) {
  return command.get_parent() ? PathOf(*command.get_parent()) + ' ' + command.get_name() : command.get_name();
}

std::vector<const CLI::App*> AllOf(const CLI::App& command) {
  std::vector<const CLI::App*> all = {&command};
  for (const CLI::App* verb : VerbsOf(command)) {
    const std::vector<const CLI::App*> below = AllOf(*verb);
    all.insert(all.end(), below.begin(), below.end());
  }
  return all;
}

std::string UsageOf(const CLI::App& command) {
  std::string usage = PathOf(command);
  if (!OptionsOf(command).empty()) usage += " [OPTIONS]";
  for (const CLI::Option* each : PositionalsOf(command)) {
    const std::string name = each->get_name() + (each->get_expected_max() > 1 ? "..." : "");
    usage += each->get_required() ? ' ' + name : " [" + name + ']';
  }
  if (!VerbsOf(command).empty()) usage += command.get_require_subcommand_min() > 0 ? " VERB" : " [VERB]";
  return usage;
}

std::string TermOf(const CLI::Option& option) {
  const std::string type = TypeOf(option);
  const std::string name = option.nonpositional() ? option.get_name(false, true) : option.get_name();
  return option.nonpositional() && TakesValue(option) ? name + ' ' + (type.empty() ? "TEXT" : type) : name;
}

std::string ExplanationOf(const CLI::Option& option) {
  std::string text = option.get_description();
  if (const auto words = WordsOf(option); !words.empty())
    text += fmt::format("{}one of {}", text.empty() ? "" : "; ", fmt::join(words, ", "));
  if (!option.get_default_str().empty()) text += fmt::format(" (default {})", option.get_default_str());
  if (option.get_required() && option.nonpositional()) text += " (must be given)";
  return text;
}

std::string TypeOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::string name = type.substr(0, type.find_first_of(":"));
  return name == "TEXT" && !WordsOf(option).empty() ? "WORD" : name;
}

std::vector<std::string> WordsOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t from = type.find('{'), until = type.find('}');
  std::vector<std::string> words;
  if (from == std::string::npos || until == std::string::npos) return words;
  std::istringstream list(type.substr(from + 1, until - from - 1));
  for (std::string word; std::getline(list, word, ',');) words.push_back(word);
  return words;
}

bool TakesValue(const CLI::Option& option) { return option.get_expected_max() > 0; }

std::string ListedKind(const std::string& type) {
  static const std::map<std::string, std::string> kKinds = {
      {"SCENARIO", "scenarios"}, {"CAMPAIGN", "campaigns"}, {"TUNING", "tunings"}, {"CAMERA", "cameras"}};
  const auto found = kKinds.find(type);
  return found == kKinds.end() ? "" : found->second;
}

}  // namespace kestrel::app
