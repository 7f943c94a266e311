// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace kestrel::app {

// What the main of every program has in common: verbs, plug-ins, and errors that become an exit status.
class Program {
 public:
  // `name`: what help calls it.
  Program(const std::string& name, const std::string& description);

  CLI::App& command_line() { return command_line_; }

  // In the order in which help shows them. `act` returns the exit status.
  void Add(CLI::App* verb, std::function<int()> act);

  // Once all verbs are there. Parses the command line, has `begin` done, loads the plug-ins, and acts. Mistakes
  // of the user are printed, and end with kBadInput; all else that is thrown ends with kBrokeOff.
  int Run(int argc, char** argv, const std::function<void()>& begin = {});

  // `--plugin`, to verbs of these names.
  void TakePlugins(const std::vector<std::string>& verbs);

 private:
  struct Verb {
    const CLI::App* command;
    std::function<int()> act;
  };
  CLI::App command_line_;
  std::vector<Verb> verbs_;
  std::vector<std::string> plugins_;
};

}  // namespace kestrel::app
