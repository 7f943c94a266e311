// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace kestrel::app {

// `kestrel explain`: what a key of a file means, what it may be, and what it is by default.
struct ExplainArguments {
  std::string key;        // dotted; empty: the kinds of files, or the keys of one
  std::string kind = {};  // empty: all
};

CLI::App* AddExplainCommand(CLI::App& app, ExplainArguments& arguments);

// Throws InputError: no file has such a key.
void ExplainCommand(const ExplainArguments& arguments);

std::string ExplainText(const ExplainArguments& arguments);

}  // namespace kestrel::app
