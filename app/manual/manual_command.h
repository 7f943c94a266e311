// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace kestrel::app {

// `completion`, `man` and `reference`: what a program's verbs and options are, for shells, man and docs/.
struct ManualArguments {
  std::string shell;
  std::string page = "commands";  // of docs/reference
};

CLI::App* AddCompletionCommand(CLI::App& app, ManualArguments& arguments);
CLI::App* AddManCommand(CLI::App& app);
CLI::App* AddReferenceCommand(CLI::App& app, ManualArguments& arguments);  // which help does not show

void CompletionCommand(const CLI::App& app, const ManualArguments& arguments);
void ManCommand(const CLI::App& app);
void ReferenceCommand(const CLI::App& app);

}  // namespace kestrel::app
