// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel list`: what there is of a kind, with a sentence each.
struct ListArguments {
  std::string kind = "scenarios";
  bool json = false, names = false;
};

CLI::App* AddListCommand(CLI::App& app, ListArguments& arguments);

// Throws InputError: there is nothing of the kind.
void ListCommand(const ListArguments& arguments);

// A line for each that there is of a kind: its name and its sentence, or why it is not valid.
std::string ListText(const std::string& kind);

}  // namespace kestrel::app
