// SPDX-License-Identifier: Apache-2.0
#include "app/manual/manual_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/manual/completion.h"
#include "app/manual/man_page.h"
#include "app/manual/reference.h"
#include "app/option/one_of.h"
#include "base/version.h"

namespace kestrel::app {

CLI::App* AddCompletionCommand(CLI::App& app, ManualArguments& a) {
  CLI::App* command =
      app.add_subcommand("completion", "Print the script by which a shell completes commands");
  command->add_option("shell", a.shell, "Which")->required()->check(OneOf({"bash", "zsh", "fish"}));
  command->footer("Example:\n  source <(kestrel completion bash)");
  return command;
}

CLI::App* AddManCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("man", "Print the man page");
  command->footer("Example:\n  kestrel man | man -l -");
  return command;
}

CLI::App* AddReferenceCommand(CLI::App& app, ManualArguments& a) {
  CLI::App* command = app.add_subcommand("reference", "Print a page of docs/reference")->group("");
  command->add_option("page", a.page, "Which")->check(OneOf({"commands", "files"}))->capture_default_str();
  return command;
}

void CompletionCommand(const CLI::App& app, const ManualArguments& a) {
  fmt::print("{}", a.shell == "bash"  ? BashCompletion(app)
                   : a.shell == "zsh" ? ZshCompletion(app)
                                      : FishCompletion(app));
}

void ManCommand(const CLI::App& app) { fmt::print("{}", ManPage(app, Version())); }

void ReferenceCommand(const CLI::App& app) { fmt::print("{}", CommandReference(app)); }

}  // namespace kestrel::app
