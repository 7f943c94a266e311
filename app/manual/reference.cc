// SPDX-License-Identifier: Apache-2.0
#include "app/manual/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "app/option/command_tree.h"

namespace kestrel::app {
namespace {

constexpr std::size_t kColumns = 140;

// Broken into lines, of which all but the first begin so.
std::string Broken(const std::string& text, const std::string& indent) {
  std::string broken;
  std::size_t column = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const bool breaks = column > 0 && column + 1 + word.size() > kColumns;
    if (column > 0) broken += breaks ? '\n' + indent : " ";
    column = (breaks ? indent.size() : column == 0 ? 0 : column + 1) + word.size();
    broken += word;
  }
  return broken + '\n';
}

std::string Item(const std::string& text) { return Broken("- " + text, "  "); }

std::string Arguments(const CLI::App& command) {
  std::string items;
  for (const CLI::Option* each : PositionalsOf(command))
    items += Item(fmt::format("`{}`: {}", TermOf(*each), ExplanationOf(*each)));
  for (const CLI::Option* each : OptionsOf(command))
    if (each != command.get_help_ptr())  // which every verb has
      items += Item(fmt::format("`{}`: {}", TermOf(*each), ExplanationOf(*each)));
  return items.empty() ? items : items + '\n';
}

// As it is printed; lines that are not set out by spaces are broken.
std::string Block(const std::string& text) {
  std::string block = "```text\n";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    block += line.starts_with(' ') ? line + '\n' : Broken(line, "");
  return block + "```\n\n";
}

}  // namespace

std::string CommandReference(const CLI::App& app) {
  std::string page = fmt::format(
      "# Commands\n\nThis page is printed by `{0} reference`, and is not edited. `{0} VERB --help` says the "
      "same.\n\n"
      "{1}\n\n",
      app.get_name(), app.get_description());
  for (const CLI::App* command : AllOf(app)) {
    if (command == &app) continue;
    std::string anchor = PathOf(*command);
    std::replace(anchor.begin(), anchor.end(), ' ', '-');
    page += Item(fmt::format("[`{}`](#{}): {}", PathOf(*command).substr(app.get_name().size() + 1), anchor,
                             command->get_description()));
  }
  page += '\n';
  for (const CLI::App* command : AllOf(app)) {
    if (command == &app) continue;
    page += fmt::format("## {}\n\n{}.\n\n{}{}", PathOf(*command), command->get_description(),
                        Block(UsageOf(*command)), Arguments(*command));
    if (!command->get_footer().empty()) page += Block(command->get_footer());
  }
  page.pop_back();
  return page;
}

}  // namespace kestrel::app
