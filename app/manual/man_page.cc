// SPDX-License-Identifier: Apache-2.0
#include "app/manual/man_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "app/option/command_tree.h"

namespace kestrel::app {
namespace {

// A text as roff prints it: its hyphens, backslashes, and what begins a line as a request would.
std::string Roff(const std::string& text) {
  std::string roff;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) roff += "\\&";
    line_begins = c == '\n';
    if (c == '\\')
      roff += "\\e";
    else if (c == '-')
      roff += "\\-";
    else if (c == '\'')
      roff += "\\(aq";
    else if (c == '`')
      roff += "\\(ga";
    else if (c == '^')
      roff += "\\(ha";
    else if (c == '~')
      roff += "\\(ti";
    else
      roff += c;
  }
  return roff;
}

// Lines that are set out by spaces stay as they are; others are filled.
std::string Paragraphs(const std::string& text) {
  std::string roff;
  bool as_it_is = false, begins = true;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const bool set_out = line.starts_with("  ");
    if (set_out != as_it_is) roff += set_out ? ".PP\n.EX\n" : ".EE\n";
    if (!set_out && (line.empty() || begins || as_it_is)) roff += ".PP\n";
    as_it_is = set_out, begins = false;
    if (!line.empty()) roff += Roff(line) + '\n';
  }
  return roff + (as_it_is ? ".EE\n" : "");
}

std::string Terms(const std::vector<const CLI::Option*>& options) {
  std::string roff;
  for (const CLI::Option* each : options) {
    const std::string term = TermOf(*each);
    const std::size_t space = term.find(' ');
    roff += fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", Roff(term.substr(0, space)),
                        space == std::string::npos ? "" : " \\fI" + Roff(term.substr(space + 1)) + "\\fR",
                        Roff(ExplanationOf(*each)));
  }
  return roff;
}

}  // namespace

std::string ManPage(const CLI::App& app, const std::string& version) {
  std::string title = app.get_name();
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  const std::string about = app.get_description();
  // "about" of "Kestrel: about."
  std::string first = about.substr(0, about.find('\n'));
  if (const std::size_t colon = first.find(": "); colon != std::string::npos) first = first.substr(colon + 2);
  if (first.ends_with('.')) first.pop_back();
  std::string roff = fmt::format(
      ".TH {} 1 \"\" \"{} {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n\\fB{}\\fR "
      "[\\fIOPTIONS\\fR] "
      "\\fIVERB\\fR ...\n.SH DESCRIPTION\n{}",
      title, app.get_name(), Roff(version), app.get_name(), Roff(first), app.get_name(), Paragraphs(about));
  roff += Terms(OptionsOf(app)) + ".SH VERBS\n";
  for (const CLI::App* command : AllOf(app)) {
    if (command == &app) continue;
    roff += fmt::format(".SS {}\n\\fB{}\\fR\n{}", Roff(UsageOf(*command).substr(app.get_name().size() + 1)),
                        Roff(UsageOf(*command)), Paragraphs(command->get_description() + "."));
    roff += Terms(PositionalsOf(*command)) + Terms(OptionsOf(*command)) + Paragraphs(command->get_footer());
  }
  return roff +
         ".SH ENVIRONMENT\n.TP\n\\fBKESTREL_ROOT\\fR\nThe folder that holds scenarios/ and models/.\n"
         ".TP\n\\fBNO_COLOR\\fR\nNo colours are printed where this is set.\n" +
         (app.get_footer().empty() ? "" : ".SH EXAMPLES\n" + Paragraphs(app.get_footer()));
}

}  // namespace kestrel::app
