// SPDX-License-Identifier: Apache-2.0
#include "app/manual/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "app/option/command_tree.h"

namespace kestrel::app {
namespace {

// In single quotes, as all three shells take them but for the quote itself.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + '\'';
}

// The call in the bash script that offers what a value may be.
std::string OfferOf(const CLI::Option& option, const std::string& program) {
  const std::string type = TypeOf(option);
  if (const auto words = WordsOf(option); !words.empty())
    return fmt::format("_{}_words {}", program, Quoted(fmt::format("{}", fmt::join(words, " "))));
  if (const std::string kind = ListedKind(type); !kind.empty())
    return fmt::format("_{}_listed {}", program, kind);
  if (type == "FILE") return fmt::format("_{}_files", program);
  if (type == "DIR") return fmt::format("_{}_folders", program);
  return ":";
}

std::string NamesOf(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* each : OptionsOf(command))
    for (const std::string& name : each->get_lnames()) names.push_back("--" + name);
  return fmt::format("{}", fmt::join(names, " "));
}

// The functions that bash and zsh have in common.
std::string Functions(const CLI::App& app) {
  const std::string program = app.get_name();
  std::string verbs, values, words;
  for (const CLI::App* command : AllOf(app)) {
    const std::string path = PathOf(*command);
    std::vector<std::string> below;
    for (const CLI::App* verb : VerbsOf(*command)) {
      below.push_back(verb->get_name());
      verbs += fmt::format("      '{0}') verb='{0}' ;;\n", PathOf(*verb));
    }
    for (const CLI::Option* option : OptionsOf(*command))
      if (TakesValue(*option))
        values += fmt::format("    '{} --{}') {}; return ;;\n", path, option->get_lnames().front(),
                              OfferOf(*option, program));
    std::string offers;
    if (!below.empty())
      offers += fmt::format("_{}_words {}; ", program, Quoted(fmt::format("{}", fmt::join(below, " "))));
    if (const auto positionals = PositionalsOf(*command); !positionals.empty())
      offers += OfferOf(*positionals.front(), program) + "; ";
    words += fmt::format("    '{}')\n      if [[ $current == -* ]]; then _{}_words {}; else {}fi ;;\n", path,
                         program, Quoted(NamesOf(*command)), offers.empty() ? ":; " : offers);
  }
  return fmt::format(R"bash(_{0}_words() {{ COMPREPLY+=($(compgen -W "$1" -- "$current")); }}
_{0}_files() {{ compopt -o filenames 2>/dev/null; COMPREPLY+=($(compgen -f -- "$current")); }}
_{0}_folders() {{ compopt -o filenames 2>/dev/null; COMPREPLY+=($(compgen -d -- "$current")); }}
_{0}_listed() {{ _{0}_words "$("$program" list "$1" --names 2>/dev/null)"; _{0}_files; }}
_{0}() {{
  local program=${{COMP_WORDS[0]}} current=${{COMP_WORDS[COMP_CWORD]}} verb={0} i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    case "$verb ${{COMP_WORDS[i]}}" in
{1}    esac
  done
  case "$verb ${{COMP_WORDS[COMP_CWORD - 1]}}" in
{2}  esac
  case "$verb" in
{3}  esac
}}
)bash",
                     program, verbs, values, words);
}

}  // namespace

std::string BashCompletion(const CLI::App& app) {
  return fmt::format(
      "# Completion of {0} for bash, printed by `{0} completion bash`.\n{1}complete -F _{0} {0}\n",
      app.get_name(), Functions(app));
}

std::string ZshCompletion(const CLI::App& app) {
  return fmt::format(
      "#compdef {0}\n# Completion of {0} for zsh, printed by `{0} completion zsh`.\n"
      "autoload -U +X bashcompinit && bashcompinit\n{1}complete -F _{0} {0}\n",
      app.get_name(), Functions(app));
}

std::string FishCompletion(const CLI::App& app) {
  const std::string program = app.get_name();
  std::string text = fmt::format(
      "# Completion of {0} for fish, printed by `{0} completion fish`.\ncomplete -c {0} -f\n", program);
  for (const CLI::App* command : AllOf(app)) {
    // After the verbs of its path, and before any below it.
    std::vector<std::string> seen;
    for (const CLI::App* each = command; each->get_parent(); each = each->get_parent())
      seen.insert(seen.begin(), "__fish_seen_subcommand_from " + each->get_name());
    std::vector<std::string> below;
    for (const CLI::App* verb : VerbsOf(*command)) below.push_back(verb->get_name());
    if (!below.empty())
      seen.push_back(fmt::format("not __fish_seen_subcommand_from {}", fmt::join(below, " ")));
    const std::string condition = Quoted(fmt::format("{}", fmt::join(seen, "; and ")));
    const auto values = [&](const CLI::Option& option) -> std::string {
      const std::string type = TypeOf(option);
      if (const auto words = WordsOf(option); !words.empty())
        return fmt::format(" -a {}", Quoted(fmt::format("{}", fmt::join(words, " "))));
      if (const std::string kind = ListedKind(type); !kind.empty())
        return fmt::format(" -F -a {}",
                           Quoted(fmt::format("({} list {} --names 2>/dev/null)", program, kind)));
      return type == "FILE" || type == "DIR" ? " -F" : "";
    };
    for (const CLI::App* verb : VerbsOf(*command))
      text += fmt::format("complete -c {} -n {} -a {} -d {}\n", program, condition, verb->get_name(),
                          Quoted(verb->get_description()));
    for (const CLI::Option* option : OptionsOf(*command))
      text += fmt::format("complete -c {} -n {} -l {}{}{} -d {}\n", program, condition,
                          option->get_lnames().front(), TakesValue(*option) ? " -r" : "",
                          TakesValue(*option) ? values(*option) : "", Quoted(option->get_description()));
    if (const auto positionals = PositionalsOf(*command); !positionals.empty())
      if (const std::string offered = values(*positionals.front()); !offered.empty())
        text += fmt::format("complete -c {} -n {}{}\n", program, condition, offered);
  }
  return text;
}

}  // namespace kestrel::app
