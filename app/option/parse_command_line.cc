// SPDX-License-Identifier: Apache-2.0
#include "app/option/parse_command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "app/option/command_tree.h"
#include "app/option/exit_status.h"
#include "base/nearest_name.h"
#include "base/printable.h"
#include "base/process/print_note.h"

namespace kestrel::app {
namespace {

using Words = std::vector<std::string>;

Words NamesOfVerbs(const CLI::App& app) {
  Words names;
  for (const CLI::App* each : VerbsOf(app)) names.push_back(each->get_name());
  return names;
}

Words NamesOfOptions(const CLI::App& app) {
  Words names;
  for (const CLI::Option* each : OptionsOf(app))
    for (const std::string& name : each->get_lnames()) names.push_back("--" + name);
  return names;
}

// Of `campaign replya dispersion`, whose first word was taken for a campaign, the first: what was meant to be a
// verb.
std::string MeantAsVerb(const CLI::App& app, const std::string& word, const Words& verbs) {
  for (const CLI::Option* each : PositionalsOf(app))
    for (const std::string& taken : each->results())
      if (NearestName(taken, verbs)) return taken;
  return word;
}

std::string NoVerb(const CLI::App& app, const std::string& word) {
  return fmt::format("{}: there is no verb '{}'; {}", PathOf(app), word,
                     RemedyForName(word, NamesOfVerbs(app)));
}

// What a word that no verb and no option took should have been.
std::string Unexpected(const CLI::App& app, const std::string& word) {
  const std::string path = PathOf(app);
  if (word.starts_with("-")) {
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("{}: there is no option '{}'; {}", path, name,
                       RemedyForName(name, NamesOfOptions(app)));
  }
  const Words verbs = NamesOfVerbs(app);
  if (!verbs.empty()) return NoVerb(app, MeantAsVerb(app, word, verbs));
  return fmt::format("{}: '{}' is one word too many", path, word);
}

// What CLI11 says, in our words; of a value, what would be valid.
std::string ErrorText(const CLI::App& verb, const CLI::ParseError& error) {
  const std::string text = error.what();
  const auto between = [&](std::string_view before, std::string_view after) {
    const std::size_t from = before.size(), until = text.find(after, from);
    return text.starts_with(before) && until != std::string::npos ? text.substr(from, until - from) : "";
  };
  if (error.get_name() == "RequiredError") {
    if (const CLI::Option* option = verb.get_option_no_throw(between("", " is required")))
      return fmt::format("{}; valid: {}", text, option->get_description());
  } else if (error.get_name() == "ConversionError") {
    const std::string name = between("Could not convert: ", " = ");
    if (const CLI::Option* option = verb.get_option_no_throw(name))
      return fmt::format("{}: '{}' is not valid; valid: {}", name, fmt::join(option->results(), " "),
                         option->get_type_name().starts_with("FLOAT") ? "a number" : "a whole number");
  } else if (const std::string name = between("", ": "); text.ends_with(" missing") && !name.empty()) {
    return name + ": its value is missing";
  }
  return text;
}

int Refuse(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* verb = &app;
  while (!verb->get_subcommands().empty()) verb = verb->get_subcommands().front();
  const Words unexpected = app.remaining(true);
  std::string text;
  for (std::size_t i = 0; i < unexpected.size(); ++i) {
    // The value of an option that is not known says nothing of its own, nor do the words after a wrong verb.
    const bool of_option = i > 0 && unexpected[i - 1].starts_with("-") && !unexpected[i].starts_with("-");
    if (of_option || (i > 0 && !NamesOfVerbs(*verb).empty())) continue;
    text += Unexpected(*verb, unexpected[i]) + '\n';
  }
  if (text.empty() && !NamesOfVerbs(*verb).empty() && verb->get_require_subcommand_min() > 0)
    text = fmt::format("{}: a verb is missing; valid: {}\n", PathOf(*verb),
                       fmt::join(NamesOfVerbs(*verb), ", "));
  if (text.empty()) text = fmt::format("{}: {}\n", PathOf(*verb), ErrorText(*verb, error));
  PrintNote("{}`{} --help` tells more\n", Printable(text), PathOf(*verb));
  return kBadInput;
}

}  // namespace

std::optional<int> ParseCommandLine(CLI::App& app, int argc, const char* const* argv) {
  Words words(argv + std::min(argc, 1), argv + argc);
  // At this door for every name that the command line gives, to whatever it is handed later: a script, a
  // program, a terminal.
  if (const auto word = std::find_if(words.begin(), words.end(), HasControl); word != words.end()) {
    const bool of_option = word != words.begin() && word[-1].starts_with("--");
    PrintNote("{}: '{}' holds a control character; valid: words without\n",
              of_option ? Printable(word[-1]) : "kestrel", Printable(*word));
    return kBadInput;
  }
  if (!words.empty() && words.front() == "version") words = {"--version"};
  if (!words.empty() && words.front() == "help") {
    words.erase(words.begin());
    const CLI::App* verb = &app;
    for (const std::string& word : words) {
      const auto below =
          verb->get_subcommands([&](const CLI::App* each) { return each->get_name() == word; });
      if (below.empty()) {
        PrintNote("{}\n",
                  Printable(NamesOfVerbs(*verb).empty() ? Unexpected(*verb, word) : NoVerb(*verb, word)));
        return kBadInput;
      }
      verb = below.front();
    }
    words.push_back("--help");
  }
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    app.parse(words);
  } catch (const CLI::Success& asked) {  // --help, --version
    app.exit(asked);
    return kMet;
  } catch (const CLI::ParseError& error) {
    return Refuse(app, error);
  }
  return std::nullopt;
}

}  // namespace kestrel::app
